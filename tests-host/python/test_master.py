"""What python-canopen offers a master, against a running device of either engine."""

import pathlib

import canopen
import pytest

import conftest

ROOT = pathlib.Path(__file__).parents[2]
NODE_ID = 127


@pytest.fixture
def device(network, node):
    """The node with its data sheet; it was restarted."""
    dictionary = canopen.import_od(str(ROOT / "eds" / "NM172.eds"), NODE_ID)
    device = network.add_node(canopen.RemoteNode(NODE_ID, dictionary))
    device.sdo.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
    return device


def test_scanner(network, node):
    """NM17x SDO-03: an upload to everybody finds the one that is there."""
    network.scanner.reset()
    network.scanner.search()
    network.subscribe(0x580 + NODE_ID, answered := conftest.Messages())
    answered.next()
    assert network.scanner.nodes == [NODE_ID]


def test_node_states_and_heartbeat(device):
    """NM17x NMT-01, NMT-02, HB-01: every command, and the state in the heartbeat."""
    conftest.walk_states(device)
    boot_up = conftest.BootUp(device.network, NODE_ID)
    device.nmt.state = "RESET COMMUNICATION"
    boot_up.next()
    assert device.sdo["Producer heartbeat time"].raw == 0


def test_process_data(bench, network, device):
    """NM17x PDO-02, PDO-03, PDO-05, PDO-09: read, configured, saved and received."""
    device.tpdo.read()
    pdo = device.tpdo[2]
    assert pdo.cob_id == 0x280 + NODE_ID
    assert pdo.enabled and not pdo.rtr_allowed and pdo.trans_type == 255
    carried = [(variable.index, variable.subindex, variable.length) for variable in pdo]
    assert carried == [(0x6004, 0, 32), (0x2501, 4, 16), (0x204E, 1, 16)]
    position = pdo[0]
    pdo.trans_type = 2
    pdo.save()
    assert device.sdo[0x1801][2].raw == 2
    device.nmt.state = "OPERATIONAL"
    received = conftest.Messages()
    pdo.add_callback(received)
    network.sync.transmit()
    network.sync.transmit()
    received.next()
    before = position.raw
    bench.tell("shaft", steps=4096)
    while position.raw != before + 400:
        network.sync.transmit()
        network.sync.transmit()
        received.next()
    bench.tell("shaft", steps=-4096)


def test_emergencies(bench, device):
    """NM17x LINK-06, EMCY-01, EMCY-05: an error and its end reach the log of the master."""
    received = conftest.Messages()
    device.emcy.add_callback(received)
    bench.tell("link", cut=True)
    received.next()
    received.next()
    bench.tell("link", cut=False)
    while received.next().code != 0:
        pass
    assert {error.code for error in device.emcy.log} == {0x8310, 0}
    assert device.emcy.active == []


def test_several_masters(bench, device):
    """NM17x NMT-01, HB-01, SDO-03: what one does, all see, and each may ask."""
    others = []
    for _ in range(3):
        other = conftest.attach(bench, 125_000)
        node = other.add_node(canopen.RemoteNode(NODE_ID, device.object_dictionary))
        node.sdo.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
        others.append((node, conftest.Messages()))
        node.nmt.add_heartbeat_callback(others[-1][1])
    device.sdo["Producer heartbeat time"].raw = 50
    for asks, _ in others:
        asks.nmt.state = "OPERATIONAL"
        for node, beats in others:
            while beats.next() != 5:
                pass
            assert node.nmt.state == "OPERATIONAL"
        assert asks.sdo.upload(0x1000, 0) == device.sdo.upload(0x1000, 0)
        asks.nmt.state = "PRE-OPERATIONAL"
        for _, beats in others:
            while beats.next() != 127:
                pass
    for node, _ in others:
        node.network.disconnect()
