"""A bench in a process of its own, and a CANopen master written by others attached to it."""

import json
import os
import queue
import socket
import subprocess

import can
import canopen
import pytest

# Bounds a hang; nothing is timed by it.
ANSWER_TIME_MAX_S = 60


class Bench:
    """The device on its virtual bus, with virtual time following the wall clock."""

    def __init__(self, product, *options):
        self.process = subprocess.Popen(
            [os.environ.get("SPINDLE_BENCH", "target/debug/bench"), "up", product, "--no-tui"]
            + ["--slcan", "127.0.0.1:0", "--control", "127.0.0.1:0", *options],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
        )
        line = self.process.stdout.readline()
        assert line, "the bench is not up"
        ready = json.loads(line)
        self.slcan = "socket://" + ready["slcan"]
        host, port = ready["control"].rsplit(":", 1)
        self.control = socket.create_connection((host, int(port)), timeout=ANSWER_TIME_MAX_S)
        self.answers = self.control.makefile("r")

    def tell(self, verb, **fields):
        """Asks the control port and expects that it was done."""
        self.control.sendall((json.dumps({"id": 1, "do": verb, **fields}) + "\n").encode())
        answer = json.loads(self.answers.readline())
        assert answer["ok"], f"{verb} {fields}: {answer.get('error')}"
        return answer

    def stop(self):
        """Ends the bench as a user does; it says whether something was wrong with the run."""
        self.process.send_signal(subprocess.signal.SIGINT)
        return self.process.wait(timeout=ANSWER_TIME_MAX_S)


def attach(bench, bit_rate):
    """A master that is on the bus: the version is told behind the opening of the channel, which nobody
    waits for. A device that starts before has its boot-up message acknowledged by the control port, and
    the master misses it."""
    channel = can.Bus(
        interface="slcan", channel=bench.slcan, bitrate=bit_rate, sleep_after_open=0
    )
    assert channel.get_version(ANSWER_TIME_MAX_S) == (1, 1)
    network = canopen.Network(channel)
    network.connect()
    return network


@pytest.fixture(scope="session", params=["twin", "image"])
def bench(request):
    bench = Bench("nm172", "--engine", request.param)
    yield bench
    assert bench.stop() == 0


@pytest.fixture(scope="session")
def network(bench):
    network = attach(bench, 125_000)
    yield network
    network.disconnect()


@pytest.fixture
def node(network):
    """Node 127 in Pre-operational, after a restart that the master has seen."""
    node = network.add_node(canopen.RemoteNode(127, canopen.ObjectDictionary()))
    node.sdo.RESPONSE_TIMEOUT = ANSWER_TIME_MAX_S
    node.sdo.MAX_RETRIES = 0
    restart(node)
    return node


def restart(node):
    """Sends Reset Node and waits for the boot-up message."""
    boot_up = BootUp(node.network, node.id)
    node.nmt.state = "RESET"
    boot_up.next()


def walk_states(node):
    """Gives every command that enters a state, and sees the state in the heartbeats."""
    node.sdo[0x1017].raw = 20
    for state in ["OPERATIONAL", "STOPPED", "PRE-OPERATIONAL", "OPERATIONAL"]:
        node.nmt.state = state
        beats = Messages()
        node.nmt.add_heartbeat_callback(beats)
        beats.next()
        beats.next()
        assert node.nmt.state == state


class Messages:
    """A callback that keeps what it is called with."""

    def __init__(self):
        self.queue = queue.Queue()

    def __call__(self, *arguments):
        self.queue.put(arguments[0])

    def next(self):
        return self.queue.get(timeout=ANSWER_TIME_MAX_S)


class BootUp(Messages):
    """The boot-up messages of a node from here on, however soon they come."""

    def __init__(self, network, node_id):
        super().__init__()
        network.subscribe(0x700 + node_id, self)

    def __call__(self, can_id, data, timestamp):
        if data == b"\0":
            self.queue.put(data)
