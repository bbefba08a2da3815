"""The data sheets of all products as two readers written by others understand them."""

import configparser
import pathlib
import subprocess
import sys

import canopen
import pytest

ROOT = pathlib.Path(__file__).parents[2]
SHEETS = sorted((ROOT / "eds").glob("*.eds"))
NODE_ID = 5


@pytest.fixture(params=SHEETS, ids=lambda path: path.stem)
def sheet(request):
    return request.param


def variables(dictionary):
    for entry in dictionary.values():
        if isinstance(entry, canopen.objectdictionary.ODVariable):
            yield entry
        else:
            yield from entry.values()


def rows(sheet):
    """Index, sub-index and default of each line of the handbook, which has the same source."""
    page = ROOT / "docs" / "od" / f"{sheet.stem.lower()}.md"
    for line in page.read_text().splitlines():
        if line.startswith("| 0x"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            yield int(cells[0], 0), int(cells[1]), cells[5]


@pytest.mark.parametrize("product", ["NM170", "NM172", "NM174"])
def test_names_of_the_files(product):
    """NM17x GEN-01."""
    assert ROOT / "eds" / f"{product}.eds" in SHEETS


def test_dcfchk_is_content(sheet):
    dcfchk = pathlib.Path(sys.executable).parent / "dcfchk"
    judged = subprocess.run([dcfchk, "-n", str(NODE_ID), sheet], capture_output=True, text=True)
    assert (judged.returncode, judged.stdout, judged.stderr) == (0, "", "")


def test_no_entry_of_the_file_is_empty(sheet):
    reader = configparser.RawConfigParser()
    reader.read(sheet)
    entries = [(name, key, value) for name in reader for key, value in reader[name].items()]
    assert [(name, key) for name, key, value in entries if not value] == []


def test_python_canopen_finds_every_object(sheet):
    """0x2110 of the encoders is not part of their data sheets (encoder EN-OPT-01)."""
    dictionary = canopen.import_od(str(sheet), NODE_ID)
    found = {(entry.index, entry.subindex) for entry in variables(dictionary)}
    expected = {(index, sub) for index, sub, _ in rows(sheet)}
    hidden = {(0x2110, 0)} if sheet.stem.startswith("G") else set()
    assert found == expected - hidden


def test_python_canopen_reads_every_default(sheet):
    dictionary = canopen.import_od(str(sheet), NODE_ID)
    values = {(entry.index, entry.subindex): entry.default for entry in variables(dictionary)}
    for index, sub, default in rows(sheet):
        if (index, sub) not in values:
            continue
        value = values[index, sub]
        name = f"0x{index:04X}:{sub}"
        if default.startswith("`"):
            assert value == default.strip("`"), name
        elif default.endswith(" + node-ID"):
            assert value == int(default.split()[0], 0) + NODE_ID, name
        elif default and not (value is None and maps_what_is_missing(dictionary, index, default)):
            assert value == int(default, 0), name


def maps_what_is_missing(dictionary, index, default):
    """The NM170 names the status of the others in its process data (NM17x A-37)."""
    return 0x1A00 <= index <= 0x1BFF and int(default, 0) >> 16 not in dictionary


@pytest.mark.parametrize(
    "file, vendor, product",
    [
        ("NM170", 0xEC, 0x70),
        ("NM172", 0xEC, 0x71),
        ("NM174", 0xEC, 0x72),
        ("AP04", 0x195, 0x4E4143),
        ("GXMMW_H", 0xEC, 0x0A),
        ("GXAMW_H", 0xEC, 0x0B),
        ("GCMMW_H", 0xEC, 0x0C),
        ("GCAMW_H", 0xEC, 0x0D),
        ("GBMMW_H", 0xEC, 0x0E),
        ("GBAMW_H", 0xEC, 0x0F),
        ("GDMM", 0xEC, 0x0E),
        ("GDAM", 0xEC, 0x0F),
    ],
)
def test_identity(file, vendor, product):
    """NM17x GEN-01, AP04 AP-ID-01, encoder EN-VAR-01."""
    dictionary = canopen.import_od(str(ROOT / "eds" / f"{file}.eds"), NODE_ID)
    device = dictionary.device_information
    assert (device.vendor_number, device.product_number) == (vendor, product)
    assert [dictionary[0x1018][sub].default for sub in (1, 2)] == [vendor, product]
