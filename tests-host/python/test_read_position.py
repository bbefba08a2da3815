"""The device as python-canopen meets it over an SLCAN adapter."""

import pathlib
import queue
import subprocess
import sys

import canopen
import pytest


ROOT = pathlib.Path(__file__).parents[2]


def position_of(frame):
    return int.from_bytes(frame[:4], "little", signed=True)


def test_boot_up(network, node):
    """NM17x BOOT-03, NMT-02, NMT-03, GEN-05: node 127 reports at 125 kbit/s."""
    assert node.nmt.state in ("INITIALISING", "PRE-OPERATIONAL")
    assert network.nmt is not None


@pytest.mark.parametrize(
    "index, sub, expected",
    [
        (0x1000, 0, (0x00020196).to_bytes(4, "little")),
        (0x1008, 0, b"NM172 Standard"),
        (0x1018, 1, (0xEC).to_bytes(4, "little")),
        (0x1018, 2, (0x71).to_bytes(4, "little")),
        (0x2101, 0, b"\x7f"),
    ],
)
def test_sdo_upload(node, index, sub, expected):
    """NM17x OD-1000-1, OD-1008-1, OD-1018-1, SDO-03, SDO-08: segmented where it is long."""
    assert node.sdo.upload(index, sub) == expected


def test_sdo_download_and_abort(node):
    """NM17x SDO-04, SDO-05, SDO-06, SDO-10: a window of 3.20 mm, and what is no value."""
    node.sdo.download(0x2003, 0, (320).to_bytes(4, "little"))
    assert node.sdo.upload(0x2003, 0) == (320).to_bytes(4, "little")
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        node.sdo.download(0x2000, 5, (2).to_bytes(4, "little"))
    assert aborted.value.code == 0x06090030
    with pytest.raises(canopen.SdoAbortedError) as aborted:
        node.sdo.upload(0x5000, 0)
    assert aborted.value.code == 0x06020000


def test_position_follows_the_shaft(bench, network, node):
    """NM17x OD-6004-1, PDO-01, PDO-04, PDO-09: TxPDO2 reports what the shaft does."""
    before = int.from_bytes(node.sdo.upload(0x6004, 0), "little", signed=True)
    frames = queue.Queue()
    network.subscribe(0x280 + 127, lambda cob_id, data, time: frames.put(bytes(data)))
    node.nmt.state = "OPERATIONAL"
    # One turn of the sensor is 4096 places, and 4.00 mm with the scaling at delivery.
    bench.tell("shaft", steps=4096)
    frame = frames.get(timeout=60)
    while abs(position_of(frame) - before) < 400:
        frame = frames.get(timeout=60)
    assert len(frame) == 8
    assert position_of(frame) == before + 400
    assert int.from_bytes(node.sdo.upload(0x6004, 0), "little", signed=True) == before + 400


def test_the_script_of_the_readme(bench):
    """NM17x BOOT-03, PDO-09: what a user types first shows the position."""
    script = (ROOT / "docs" / "read_position.py").read_text()
    assert script in (ROOT / "README.md").read_text()
    script = script.replace("socket://127.0.0.1:29536", bench.slcan)
    # A loaded machine may run the bench slower than real time.
    patience = "import canopen.sdo; canopen.sdo.SdoClient.RESPONSE_TIMEOUT = 60\n"
    script = patience + script.replace("wait_for_bootup()", "wait_for_bootup(60)")
    user = subprocess.Popen(
        [sys.executable, "-u", "-c", script],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    lines = iter(user.stdout.readline, "")
    assert next(lines) == "node 127 has booted\n"
    objects = [next(lines) for _ in range(4)]
    assert objects[1] == "0x1008 b'NM172 Standard'\n"
    assert next(lines) == "Turn the shaft; Enter ends.\n"
    bench.tell("shaft", steps=4096)
    assert next(lines).endswith(" mm\n")
    user.communicate("\n", timeout=60)
    assert user.returncode == 0
