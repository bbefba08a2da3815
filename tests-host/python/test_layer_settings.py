"""Node-ID and bit rate over the bus, as python-canopen sets them, on an encoder."""

import canopen
import pytest

import conftest

VENDOR, PRODUCT, REVISION, SERIAL = 0xEC, 0x0A, 0x01090001, 1


@pytest.fixture
def encoder():
    bench = conftest.Bench("gxmm", "--engine", "twin")
    network = attach(bench, 50_000)
    network.nmt.state = "STOPPED"
    yield bench, network
    network.disconnect()
    assert bench.stop() == 0


def attach(bench, bit_rate):
    network = conftest.attach(bench, bit_rate)
    network.lss.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
    return network


def test_inquiries(encoder):
    """Encoder EN-LSS-02, EN-LSS-08."""
    _, network = encoder
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    inquiries = [
        (canopen.lss.CS_INQUIRE_VENDOR_ID, VENDOR),
        (canopen.lss.CS_INQUIRE_PRODUCT_CODE, PRODUCT),
        (canopen.lss.CS_INQUIRE_REVISION_NUMBER, REVISION),
        (canopen.lss.CS_INQUIRE_SERIAL_NUMBER, SERIAL),
    ]
    for command, expected in inquiries:
        assert network.lss.inquire_lss_address(command) == expected
    assert network.lss.inquire_node_id() == 1


def test_node_id_and_bit_rate(encoder):
    """Encoder EN-LSS-03 to EN-LSS-06, EN-CFG-01: selected, configured, stored, in force afterwards."""
    bench, network = encoder
    assert network.lss.send_switch_state_selective(VENDOR, PRODUCT, REVISION, SERIAL)
    network.lss.configure_node_id(9)
    network.lss.configure_bit_timing(0)
    network.lss.store_configuration()
    bench.tell("power", on=False)
    network.disconnect()
    fast = attach(bench, 1_000_000)
    node = fast.add_node(canopen.RemoteNode(9, canopen.ObjectDictionary()))
    boot_up = conftest.BootUp(fast, 9)
    bench.tell("power", on=True)
    boot_up.next()
    assert node.sdo.upload(0x2101, 0) == b"\x09"
    assert node.sdo.upload(0x2100, 0) == b"\x08"
    fast.disconnect()
