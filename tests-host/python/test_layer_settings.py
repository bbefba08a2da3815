"""Layer setting services as python-canopen sends them (CiA 305)."""

import canopen
import pytest
from canopen import lss as services

import conftest

NODE_ID = 127
OTHER_NODE_ID = 42


@pytest.fixture
def lss(network, node):
    network.lss.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
    yield network.lss
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)


@pytest.fixture
def identity(node):
    return [int.from_bytes(node.sdo.upload(0x1018, sub), "little") for sub in (1, 2, 3, 4)]


def test_everybody_tells_who_it_is(lss, identity):
    """NM17x LSS-01, LSS-02, LSS-08: without a node-ID or a data sheet."""
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    inquiries = [
        services.CS_INQUIRE_VENDOR_ID,
        services.CS_INQUIRE_PRODUCT_CODE,
        services.CS_INQUIRE_REVISION_NUMBER,
        services.CS_INQUIRE_SERIAL_NUMBER,
    ]
    assert [lss.inquire_lss_address(inquiry) for inquiry in inquiries] == identity


def test_one_device_gets_a_node_id(network, node, lss, identity):
    """NM17x ADDR-03, ADDR-04, ADDR-06, LSS-03, LSS-04, LSS-06, LSS-09: chosen by its identity, in
    force and kept after a restart."""
    moved = network.add_node(canopen.RemoteNode(OTHER_NODE_ID, canopen.ObjectDictionary()))
    for present, wanted in [(node, moved), (moved, node)]:
        assert lss.send_switch_state_selective(*identity)
        with pytest.raises(services.LssError):
            lss.configure_node_id(0)
        lss.configure_node_id(wanted.id)
        lss.store_configuration()
        lss.send_switch_state_global(lss.WAITING_STATE)
        present.nmt.state = "RESET"
        wanted.nmt.wait_for_bootup(timeout=conftest.ANSWER_TIME_MAX_S)
        wanted.sdo.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
        assert wanted.sdo.upload(0x2101, 0) == bytes([wanted.id])
