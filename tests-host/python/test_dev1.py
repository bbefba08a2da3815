"""The smallest program that is a CANopen device, with what python-canopen offers a master."""

import canopen
import pytest
from canopen.objectdictionary import ODRecord, ODVariable, datatypes

import conftest

NODE_ID = 0x10
IDENTITY = [0x1234, 2, 3, 4]
BLOCK = 0x2000
BLOCK_LEN = 64
# Of the table of CiA 305, section 6.4.
BIT_TIMING_125_KBIT_S = 4
NODE_ID_NONE = 0xFF
SCAN_TIME_MAX_S = 1
U8, U16, U32 = datatypes.UNSIGNED8, datatypes.UNSIGNED16, datatypes.UNSIGNED32


@pytest.fixture(scope="module")
def bench():
    bench = conftest.Bench("dev1")
    yield bench
    assert bench.stop() == 0


@pytest.fixture(scope="module")
def network(bench):
    network = conftest.attach(bench, 125_000)
    network.lss.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
    yield network
    network.disconnect()


@pytest.fixture
def node(bench, network):
    """The device in Pre-operational, after a power-up that the master has seen."""
    node = network.add_node(remote_node(NODE_ID))
    boot_up = conftest.BootUp(network, NODE_ID)
    bench.tell("power", on=False)
    bench.tell("power", on=True)
    boot_up.next()
    return node


def remote_node(node_id):
    node = canopen.RemoteNode(node_id, dictionary())
    node.sdo.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
    node.sdo.MAX_RETRIES = 0
    return node


def dictionary():
    """What the PDOs need."""
    objects = canopen.ObjectDictionary()
    objects.add_object(variable(0x1017, 0, U16))
    for number in range(2):
        objects.add_object(record(0x1400 + number, [U8, U32, U8, None, None, U16]))
        objects.add_object(record(0x1600 + number, [U8] + [U32] * 8))
        objects.add_object(record(0x1800 + number, [U8, U32, U8, U16, None, U16, U8]))
        objects.add_object(record(0x1A00 + number, [U8] + [U32] * 8))
    for index in [0x6000, 0x6200]:
        objects.add_object(record(index, [U8] + [U32] * 4))
        objects.add_object(record(index + 1, [U8] + [U8] * 8))
    return objects


def record(index, types):
    record = ODRecord(f"{index:04X}", index)
    for sub, data_type in enumerate(types):
        if data_type is not None:
            record.add_member(variable(index, sub, data_type))
    return record


def variable(index, sub, data_type):
    variable = ODVariable(f"{index:04X}:{sub}", index, sub)
    variable.data_type = data_type
    return variable


def test_scanner(network, node):
    network.scanner.reset()
    network.subscribe(0x580 + NODE_ID, answered := conftest.Messages())
    network.scanner.search()
    answered.next()
    assert network.scanner.nodes == [NODE_ID]


def test_transfers(node):
    """Expedited and in segments."""
    assert node.sdo.upload(0x1000, 0) == bytes.fromhex("91010300")
    node.sdo.download(0x6200, 1, bytes.fromhex("78563412"))
    assert node.sdo.upload(0x6200, 1) == bytes.fromhex("78563412")
    written = bytes(range(BLOCK_LEN))
    node.sdo.download(BLOCK, 0, written)
    assert node.sdo.upload(BLOCK, 0) == written
    with pytest.raises(canopen.SdoAbortedError) as refused:
        node.sdo.upload(0x3000, 0)
    assert refused.value.code == 0x06020000


def test_block_transfers(node):
    """With their checksum."""
    written = bytes(reversed(range(BLOCK_LEN)))
    with node.sdo.open(BLOCK, 0, "wb", size=BLOCK_LEN, block_transfer=True) as file:
        file.write(written)
    with node.sdo.open(BLOCK, 0, "rb", block_transfer=True) as file:
        assert file.read() == written


def test_process_data(network, node):
    """Read, mapped anew, saved, received and sent."""
    node.tpdo.read()
    node.rpdo.read()
    carried = [(entry.index, entry.subindex, entry.length) for entry in node.tpdo[1]]
    assert carried == [(0x6000, 1, 32), (0x6000, 2, 32)]
    pdo = node.tpdo[2]
    pdo.clear()
    pdo.add_variable(0x6201, 8)
    pdo.add_variable(0x6000, 4)
    pdo.trans_type = 1
    pdo.enabled = True
    pdo.save()
    node.tpdo.read()
    carried = [(entry.index, entry.subindex, entry.length) for entry in pdo]
    assert carried == [(0x6201, 8, 8), (0x6000, 4, 32)]
    received = conftest.Messages()
    pdo.add_callback(received)
    node.nmt.state = "OPERATIONAL"
    node.rpdo[2].data = bytearray(b"\1\2\3\4\5\6\7\x5a")
    node.rpdo[2].transmit()
    network.sync.transmit()
    received.next()
    assert (pdo[0].raw, pdo[1].raw) == (0x5A, 0x88442204)


def test_node_states_and_heartbeat(node):
    """Every command, and the state in the heartbeat."""
    conftest.walk_states(node)


def test_emergencies(network, node):
    """A PDO with too few bytes."""
    node.nmt.state = "OPERATIONAL"
    received = conftest.Messages()
    node.emcy.add_callback(received)
    network.send_message(0x200 + NODE_ID, b"\1")
    assert received.next().code == 0x8210


def test_layer_settings(network, node):
    """Selected by its identity, it loses its node-ID; then fastscan finds it, and it gets another."""
    other_id = 0x21
    lss = network.lss
    boot_up = conftest.BootUp(network, other_id)
    assert lss.send_switch_state_selective(*IDENTITY)
    assert lss.inquire_node_id() == NODE_ID
    lss.configure_node_id(NODE_ID_NONE)
    lss.send_switch_state_global(lss.WAITING_STATE)
    node.nmt.state = "RESET COMMUNICATION"
    # What does not answer a question of the scan is waited for.
    lss.RESPONSE_TIMEOUT = SCAN_TIME_MAX_S
    assert lss.fast_scan() == (True, IDENTITY)
    lss.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
    assert lss.inquire_node_id() == NODE_ID_NONE
    lss.configure_node_id(other_id)
    with pytest.raises(canopen.lss.LssError):
        lss.store_configuration()
    with pytest.raises(canopen.lss.LssError):
        lss.configure_bit_timing(BIT_TIMING_125_KBIT_S)
    lss.activate_bit_timing(0)
    lss.send_switch_state_global(lss.WAITING_STATE)
    boot_up.next()
    found = network.add_node(remote_node(other_id))
    assert found.sdo.upload(0x1018, 4) == (4).to_bytes(4, "little")
