"""Every object of every product on a running device: value, type, access and abort code."""

import dataclasses
import pathlib

import canopen
import pytest

import conftest

ROOT = pathlib.Path(__file__).parents[2]

UNKNOWN_COMMAND = 0x05040001
UNSUPPORTED_ACCESS = 0x06010000
WRITE_ONLY = 0x06010001
READ_ONLY = 0x06010002
NO_OBJECT = 0x06020000
HARDWARE_ERROR = 0x06060000
LENGTH_MISMATCH = 0x06070010
NO_SUB_INDEX = 0x06090011
VALUE_RANGE = 0x06090030
VALUE_TOO_HIGH = 0x06090031
NOT_STORED = 0x08000020
DEVICE_STATE = 0x08000022
NO_DATA = 0x08000024

STORE_AND_RESTORE = (0x1010, 0x1011)
ERROR_FIELD = 0x1003
# In no data sheet (encoder EN-OPT-01).
OPTIONS = 0x2110


def is_restricted(cob_id):
    """CiA 301 keeps some CAN-IDs for itself, section 7.3.5."""
    can_id = cob_id & 0x7FF
    ends = [(0, 0x7F), (0x101, 0x180), (0x581, 0x5FF), (0x601, 0x67F), (0x6E0, 0x7FF)]
    return any(first <= can_id <= last for first, last in ends)


@dataclasses.dataclass(frozen=True)
class Product:
    slug: str
    sheet: str
    node_id: int
    bit_rate: int
    # Abort codes for a number outside its only span.
    above: int
    below: int
    # The answer to so many bytes for an object of another length; None takes them.
    length: object
    # Objects that read something else than at delivery, because it is so.
    live: frozenset = frozenset()
    # Objects that SDO does not write (AP04 AP-SDO-06).
    not_with_sdo: frozenset = frozenset()
    # Objects that take no CAN-ID that CiA 301 keeps for itself.
    restricted: frozenset = frozenset()
    # What becomes of a number in objects that do not keep every bit.
    kept: dict = dataclasses.field(default_factory=dict)
    # Written numbers are answered with this: the device has to be in another state.
    refused: dict = dataclasses.field(default_factory=dict)


def length_of_nm17x(length, sent):
    """NM17x A-20: three bytes are no command."""
    return UNKNOWN_COMMAND if sent == 3 else UNSUPPORTED_ACCESS


def length_of_ap04(length, sent):
    """AP04 A-35: always four bytes."""
    return None if sent == 4 else LENGTH_MISMATCH


def length_of_encoder(length, sent):
    """Encoder B-11: what is too long is cut."""
    return None if sent > length else UNSUPPORTED_ACCESS


def encoder(slug, sheet):
    return Product(
        slug=slug,
        sheet=sheet,
        node_id=1,
        bit_rate=50_000,
        above=VALUE_TOO_HIGH,
        below=VALUE_RANGE,
        length=length_of_encoder,
        live=frozenset([(0x1018, 4), (0x650B, 0)]),
        kept={(0x6000, 0): lambda number: number & 0b101},
    )


def nm17x(slug):
    """The other setpoints start as the standard one (A-71); commands read the state of a motor that
    is at rest, and the correction for TxPDO2 is the one in force (A-42)."""
    at_rest = [(0x2048, 0), (0x204D, 1), (0x204D, 2), (0x204D, 3), (0x2501, 4)]
    setpoints = [(0x2020, sub) for sub in range(3, 8)]
    return Product(
        slug=slug,
        sheet=slug.upper(),
        node_id=127,
        bit_rate=125_000,
        above=VALUE_RANGE,
        below=VALUE_RANGE,
        length=length_of_nm17x,
        live=frozenset([(0x1002, 0), (0x1018, 4), (0x204E, 1), *setpoints]),
        restricted=frozenset([(0x1005, 0), (0x1014, 0)]),
        kept={command: lambda number: 0 for command in at_rest},
    )


PRODUCTS = [
    nm17x("nm170"),
    nm17x("nm172"),
    nm17x("nm174"),
    Product(
        slug="ap04",
        sheet="AP04",
        node_id=1,
        bit_rate=250_000,
        above=VALUE_RANGE,
        below=VALUE_RANGE,
        length=length_of_ap04,
        not_with_sdo=frozenset([(0x5F0C, 0), (0x5F16, 0), (0x5F19, 0)]),
        kept={
            (0x1400, 1): lambda number: number | 1 << 30,
            (0x1401, 1): lambda number: number | 1 << 30,
            (0x1800, 1): lambda number: number | 1 << 30,
            (0x1801, 1): lambda number: number & ~(1 << 30),
            (0x5F15, 0): lambda number: number or 0x524944,
            (0x6000, 0): lambda number: number & 0b101,
        },
        refused={(0x6001, 0): DEVICE_STATE},
    ),
    encoder("gxmm", "GXMMW_H"),
    encoder("gxam", "GXAMW_H"),
    encoder("gcmm", "GCMMW_H"),
    encoder("gcam", "GCAMW_H"),
    encoder("gbmm", "GBMMW_H"),
    encoder("gbam", "GBAMW_H"),
    encoder("gdmm", "GDMM"),
    encoder("gdam", "GDAM"),
]


class Device:
    """A device whose data sheet python-canopen has read."""

    def __init__(self, product):
        self.product = product
        self.bench = conftest.Bench(product.slug, "--engine", "twin")
        self.network = conftest.attach(self.bench, product.bit_rate)
        dictionary = canopen.import_od(
            str(ROOT / "eds" / f"{product.sheet}.eds"), product.node_id
        )
        self.node = self.network.add_node(canopen.RemoteNode(product.node_id, dictionary))
        self.node.sdo.RESPONSE_TIMEOUT = conftest.ANSWER_TIME_MAX_S
        self.node.sdo.MAX_RETRIES = 0
        conftest.restart(self.node)
        self.spans = dict(spans(product.sheet))
        self.in_pre_operational = set(written_in_pre_operational(product.sheet))

    def close(self):
        self.network.disconnect()
        assert self.bench.stop() == 0

    def variables(self):
        for entry in self.node.object_dictionary.values():
            if isinstance(entry, canopen.objectdictionary.ODVariable):
                yield entry
            else:
                yield from entry.values()

    def read(self, entry):
        """The bytes, or the abort code."""
        try:
            return self.node.sdo.upload(entry.index, entry.subindex)
        except canopen.SdoAbortedError as aborted:
            return aborted.code

    def write(self, index, sub, data):
        """None, or the abort code. Who writes faster than the controllers talk tries again."""
        while True:
            try:
                self.node.sdo.download(index, sub, data)
                return None
            except canopen.SdoAbortedError as aborted:
                if aborted.code != HARDWARE_ERROR:
                    return aborted.code

    def write_number(self, entry, number):
        """A number in as many bytes as the product wants."""
        length = 4 if self.product.length is length_of_ap04 else length_of(entry)
        data = number.to_bytes(length, "little", signed=number < 0)
        return self.write(entry.index, entry.subindex, data)


def lines(sheet):
    """The cells of each line of the handbook."""
    page = ROOT / "docs" / "od" / f"{sheet.lower()}.md"
    for line in page.read_text().splitlines():
        if line.startswith("| 0x"):
            yield [cell.strip() for cell in line.strip("|").split("|")]


def written_in_pre_operational(sheet):
    """The lines that can be written in this state alone."""
    for cells in lines(sheet):
        if cells[4].endswith("written in Pre-operational"):
            yield key_of(cells)


def spans(sheet):
    """The permitted numbers of each line that has any."""
    for cells in lines(sheet):
        if cells[6]:
            numbers = cells[6].split("(")[0].strip()
            ends = [span.split(" to ") for span in numbers.split("; ") if span]
            if ends:
                yield key_of(cells), [(int(span[0], 0), int(span[-1], 0)) for span in ends]


def key_of(cells):
    return int(cells[0], 0), int(cells[1])


def key(entry):
    return entry.index, entry.subindex


def name(entry):
    return f"0x{entry.index:04X}:{entry.subindex}"


def is_text(entry):
    return entry.data_type == canopen.objectdictionary.VISIBLE_STRING


def length_of(entry):
    return len(entry) // 8


def is_signed(entry):
    return entry.data_type in canopen.objectdictionary.SIGNED_TYPES


def number_in(entry, data):
    return int.from_bytes(data, "little", signed=is_signed(entry))


def judge(wrong):
    """Fails with a line for each object that answered otherwise."""
    lines = [
        " ".join(f"0x{part:X}" if isinstance(part, int) else str(part) for part in parts)
        for parts in wrong
    ]
    assert not lines, "\n" + "\n".join(lines)


@pytest.fixture(scope="module", params=PRODUCTS, ids=lambda product: product.slug)
def device(request):
    device = Device(request.param)
    yield device
    device.close()


def test_every_object_reads_its_value_at_delivery(device):
    """NM17x OD-1000-1, OD-1018-1, SDO-03; AP04 AP-ID-01, AP-SDO-02; encoder EN-ID-01, EN-SDO-02."""
    wrong = []
    for entry in device.variables():
        read = device.read(entry)
        if not entry.readable:
            expected = WRITE_ONLY
        elif entry.index == ERROR_FIELD and entry.subindex > 0:
            expected = NO_DATA
        elif is_text(entry):
            expected = entry.default.encode()
        elif key(entry) in device.product.live or entry.default is None:
            expected = read if isinstance(read, bytes) and len(read) == length_of(entry) else "any"
        else:
            expected = entry.default.to_bytes(
                length_of(entry), "little", signed=is_signed(entry)
            )
        if read != expected:
            wrong.append((name(entry), read, expected))
    judge(wrong)


def test_what_is_read_only_is_not_written(device):
    """NM17x SDO-06; AP04 AP-SDO-06; encoder EN-SDO-04."""
    wrong = []
    for entry in device.variables():
        if entry.writable and key(entry) not in device.product.not_with_sdo:
            continue
        expected = READ_ONLY
        if key(entry) in device.product.not_with_sdo:
            expected = UNSUPPORTED_ACCESS
        answer = device.write(entry.index, entry.subindex, bytes(4))
        if answer != expected:
            wrong.append((name(entry), answer, expected))
    judge(wrong)


def test_lengths(device):
    """NM17x A-20, AP04 A-35, encoder B-11."""
    wrong = []
    for entry in device.variables():
        if not writes_numbers(device, entry):
            continue
        before = device.read(entry)
        for sent in {1, 2, 3, 4} - {length_of(entry)}:
            expected = device.product.length(length_of(entry), sent)
            data = bytes(sent)
            if expected is None and isinstance(before, bytes):
                data = (before + b"\xff\xff\xff\xff")[:sent]
                if device.product.length is length_of_ap04:
                    data = before + bytes(4 - len(before))
                    expected = device.product.refused.get(key(entry))
            elif expected is None:
                continue
            answer = device.write(entry.index, entry.subindex, data)
            if answer != expected:
                wrong.append((name(entry), sent, answer, expected))
        if device.read(entry) != before:
            wrong.append((name(entry), "changed"))
    judge(wrong)


def writes_numbers(device, entry):
    return (
        entry.writable
        and not is_text(entry)
        and key(entry) not in device.product.not_with_sdo
        and entry.index not in STORE_AND_RESTORE
    )


def test_limits(device):
    """NM17x SDO-05, SDO-06; AP04 AP-SDO-06, AP-POS-06; encoder EN-POS-07, B-15: both ends of each span,
    and beyond."""
    product = device.product
    wrong = []
    for entry in device.variables():
        if not writes_numbers(device, entry) or not entry.readable:
            continue
        before = number_in(entry, device.read(entry))
        bits = length_of(entry) * 8
        lowest = -(1 << bits - 1) if is_signed(entry) else 0
        highest = lowest + (1 << bits) - 1
        permitted = device.spans.get(key(entry), [(lowest, highest)])
        if entry.min is not None:
            assert entry.min == min(first for first, _ in permitted), name(entry)
            assert entry.max == max(last for _, last in permitted), name(entry)
        for number in [end for span in permitted for end in span]:
            answer = device.write_number(entry, number)
            expected = product.refused.get(key(entry))
            if key(entry) in product.restricted and is_restricted(number):
                expected = VALUE_RANGE
            if answer != expected:
                wrong.append((name(entry), number, answer, expected))
            elif answer is None and entry.index != ERROR_FIELD:
                kept = product.kept.get(key(entry), lambda number: number)(number)
                read = number_in(entry, device.read(entry))
                if read != kept:
                    wrong.append((name(entry), number, "reads", read, "not", kept))
        beyond = [(first - 1, product.below) for first, _ in permitted]
        beyond += [(last + 1, product.above) for _, last in permitted]
        for number, code in beyond:
            inside = any(first <= number <= last for first, last in permitted)
            if inside or not lowest <= number <= highest:
                continue
            expected = code if len(permitted) == 1 else VALUE_RANGE
            answer = device.write_number(entry, number)
            if answer != expected:
                wrong.append((name(entry), number, answer, expected))
        if not is_permitted(device, entry, before):
            continue
        answer = device.write_number(entry, before)
        if answer != product.refused.get(key(entry)):
            wrong.append((name(entry), "back to", before, answer))
    judge(wrong)


def test_commands(device):
    """NM17x SDO-06: what is write only takes each of its numbers, and no other."""
    wrong = []
    for entry in device.variables():
        if not writes_numbers(device, entry) or entry.readable:
            continue
        permitted = device.spans[key(entry)]
        taken = [number for first, last in permitted for number in range(first, last + 1)]
        for number in [*taken, permitted[-1][-1] + 1]:
            answer = device.write_number(entry, number)
            expected = None if number in taken else device.product.above
            if answer != expected:
                wrong.append((name(entry), number, answer, expected))
    judge(wrong)


def test_texts(device):
    """NM17x SDO-05, SDO-06: a text has the length it has at delivery."""
    wrong = []
    for entry in device.variables():
        if not is_text(entry) or not entry.writable:
            continue
        before = device.read(entry)
        wrong_lengths = [(before[1:], VALUE_RANGE), (before + b" ", VALUE_RANGE)]
        for text, expected in [*wrong_lengths, (before[::-1], None)]:
            answer = device.write(entry.index, entry.subindex, text)
            if answer != expected:
                wrong.append((name(entry), text, answer, expected))
            read = device.read(entry)
            if read != (before if expected else text):
                wrong.append((name(entry), "reads", read))
        assert device.write(entry.index, entry.subindex, before) is None
    judge(wrong)


def test_access_in_operational(device):
    """AP04 AP-SDO-07: some objects are written in Pre-operational alone; the others, and reads, know
    no difference."""
    wrong = []
    device.node.nmt.state = "OPERATIONAL"
    for entry in device.variables():
        if not writes_numbers(device, entry) or not entry.readable:
            continue
        number = number_in(entry, device.read(entry))
        if not is_permitted(device, entry, number):
            continue
        expected = device.product.refused.get(key(entry))
        if key(entry) in device.in_pre_operational:
            expected = DEVICE_STATE
        answer = device.write_number(entry, number)
        if answer != expected:
            wrong.append((name(entry), number, answer, expected))
    device.node.nmt.state = "PRE-OPERATIONAL"
    judge(wrong)


def is_permitted(device, entry, number):
    """Whether it takes the number, which it may read all the same."""
    permitted = device.spans.get(key(entry))
    return permitted is None or any(first <= number <= last for first, last in permitted)


def test_what_does_not_exist(device):
    """NM17x SDO-05; AP04 AP-SDO-06; encoder EN-SDO-04."""
    dictionary = device.node.object_dictionary
    found = {key(entry) for entry in device.variables()}
    wrong = []
    for index in {index for index, _ in found}:
        highest = max(sub for other, sub in found if other == index)
        for sub in [highest + 1, 255]:
            answer = device.write(index, sub, bytes(4))
            if answer != NO_SUB_INDEX:
                wrong.append((f"0x{index:04X}:{sub}", answer))
        beside = index + 1
        if beside not in dictionary and beside != OPTIONS:
            answer = device.write(beside, 0, bytes(4))
            if answer != NO_OBJECT:
                wrong.append((f"0x{beside:04X}", answer))
    judge(wrong)


def test_store_and_restore(device):
    """AP04 AP-STO-03, encoder EN-STO-01, EN-STO-02: nothing happens without the signature."""
    wrong = []
    for entry in device.variables():
        if entry.index not in STORE_AND_RESTORE or not entry.writable:
            continue
        signature = {0x1010: b"save", 0x1011: b"load"}[entry.index]
        for data, expected in [(bytes(4), NOT_STORED), (b"evas", NOT_STORED), (signature, None)]:
            answer = device.write(entry.index, entry.subindex, data)
            if answer != expected:
                wrong.append((name(entry), data, answer, expected))
    judge(wrong)
