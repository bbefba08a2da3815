//! The LCD driver chip (PCF8576 family, 40 segment and 4 backplane outputs) and the glass on it.
//!
//! The chip is written over I2C only: a transaction is command bytes, each with a continuation bit
//! (bit 7), and after the last command the display data. What is not 1:4 multiplex, 1/3 bias and
//! enabled shows nothing on this glass.
//!
//! Glass: two lines of six seven-segment digits with a point to the right of each, and two
//! arrows. Digit d (0 to 5 upper line, 6 to 11 lower line, from the left) hangs on columns 2d
//! (BP0 a, BP1 b, BP2 c, BP3 point) and 2d+1 (BP0 f, BP1 g, BP2 e, BP3 d); column 24 carries the
//! left arrow on BP0 and the right one on BP1.

/// The chip's 7-bit I2C address.
pub const ADDRESS: u8 = 0x38;

/// Segment outputs, one column of display memory each.
pub const COLUMNS: usize = 40;

/// Digits of one line.
pub const PLACES: usize = 6;

const DIGITS: usize = 2 * PLACES;
const ARROWS: usize = 2 * DIGITS;
const COLUMNS_PER_BYTE: u8 = 2;
const _: () = assert!(ARROWS < COLUMNS);

/// The subaddress pins of the chip, all tied low.
const SUBADDRESS: u8 = 0;

/// The chip with its display memory.
#[derive(Clone, Debug)]
pub struct LcdChip {
    /// One nibble per column, BP0 in bit 3.
    memory: [u8; COLUMNS],
    mode: Mode,
    blinking: bool,
    pointer: u8,
    subaddress: u8,
    input: Input,
}

/// What the next byte of a transaction is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Input {
    #[default]
    Idle,
    Commands,
    Data,
}

/// The mode-set command's bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Mode {
    enabled: bool,
    half_bias: bool,
    /// M1 M0: 0 is 1:4 multiplex.
    multiplex: u8,
}

/// One command of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Command {
    LoadDataPointer(u8),
    ModeSet(Mode),
    DeviceSelect(u8),
    BankSelect,
    Blink(u8),
}

impl Command {
    /// Every pattern of the seven lower bits.
    fn parse(byte: u8) -> Self {
        match byte & 0x7F {
            bits @ 0x00..=0x3F => Self::LoadDataPointer(bits),
            bits @ 0x40..=0x5F => Self::ModeSet(Mode {
                enabled: bits & 0x08 != 0,
                half_bias: bits & 0x04 != 0,
                multiplex: bits & 0x03,
            }),
            bits @ 0x60..=0x6F => Self::DeviceSelect(bits & 0x07),
            bits @ 0x70..=0x77 => Self::Blink(bits & 0x03),
            _ => Self::BankSelect,
        }
    }
}

/// What one digit shows: bit 0 is segment a, bit 6 is g.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Digit {
    segments: u8,
    point: bool,
}

impl Default for LcdChip {
    /// After its power-on reset: disabled. The memory of a real chip is random then; here every
    /// segment is on, so that a picture enabled too early is seen.
    fn default() -> Self {
        Self {
            memory: [0xF; COLUMNS],
            mode: Mode::default(),
            blinking: false,
            pointer: 0,
            subaddress: 0,
            input: Input::Idle,
        }
    }
}

impl LcdChip {
    /// A start condition; true when the chip acknowledges. It cannot be read.
    pub fn start(&mut self, address: u8, direction: Direction) -> bool {
        let addressed = address == ADDRESS && direction == Direction::Write;
        self.input = if addressed { Input::Commands } else { Input::Idle };
        addressed
    }

    /// One byte after an acknowledged start.
    pub fn write(&mut self, byte: u8) {
        match self.input {
            Input::Idle => {}
            Input::Commands => {
                self.command(Command::parse(byte));
                if byte & 0x80 == 0 {
                    self.input = Input::Data;
                }
            }
            Input::Data => self.data(byte),
        }
    }

    /// The stop condition.
    pub fn stop(&mut self) {
        self.input = Input::Idle;
    }

    fn command(&mut self, command: Command) {
        match command {
            Command::LoadDataPointer(column) => self.pointer = column,
            Command::ModeSet(mode) => self.mode = mode,
            Command::DeviceSelect(subaddress) => self.subaddress = subaddress,
            Command::BankSelect => {}
            Command::Blink(frequency) => self.blinking = frequency != 0,
        }
    }

    fn data(&mut self, byte: u8) {
        if self.subaddress == SUBADDRESS {
            for (column, nibble) in (usize::from(self.pointer)..).zip([byte >> 4, byte & 0xF]) {
                if let Some(cell) = self.memory.get_mut(column) {
                    *cell = nibble;
                }
            }
        }
        self.pointer += COLUMNS_PER_BYTE;
        if usize::from(self.pointer) >= COLUMNS {
            self.pointer = 0;
            self.subaddress += 1;
        }
    }

    /// Whether the chip blinks the picture on its own.
    #[must_use]
    pub const fn blinking(&self) -> bool {
        self.blinking
    }

    /// The segments lit now, one nibble per column, BP0 in bit 3. All zero while the chip is not
    /// driving this glass.
    #[must_use]
    pub fn segments(&self) -> [u8; COLUMNS] {
        let driving = self.mode.enabled && !self.mode.half_bias && self.mode.multiplex == 0;
        if driving { self.memory } else { [0; COLUMNS] }
    }

    /// The upper line as read from the glass: six places, points as `.` after their place.
    #[must_use]
    pub fn upper(&self) -> String {
        text(&self.digits()[..PLACES])
    }

    /// The lower line as read from the glass.
    #[must_use]
    pub fn lower(&self) -> String {
        text(&self.digits()[PLACES..])
    }

    /// Whether the left arrow is lit.
    #[must_use]
    pub fn left_arrow(&self) -> bool {
        self.segments()[ARROWS] & 0b1000 != 0
    }

    /// Whether the right arrow is lit.
    #[must_use]
    pub fn right_arrow(&self) -> bool {
        self.segments()[ARROWS] & 0b0100 != 0
    }

    /// A picture of the glass: seven rows of 26 characters, newline after each.
    #[must_use]
    pub fn ascii(&self) -> String {
        let digits = self.digits();
        let mut picture = String::new();
        for line in digits.chunks(PLACES) {
            for row in 0..3 {
                picture.push(' ');
                for digit in line {
                    picture.push_str(&digit.ascii(row));
                }
                picture.push_str(" \n");
            }
        }
        let arrow = |lit, sign| if lit { sign } else { ' ' };
        picture.push(arrow(self.left_arrow(), '<'));
        picture.push_str(&" ".repeat(4 * PLACES));
        picture.push(arrow(self.right_arrow(), '>'));
        picture.push('\n');
        picture
    }

    #[expect(clippy::indexing_slicing, reason = "two columns per digit, asserted above")]
    fn digits(&self) -> [Digit; DIGITS] {
        let columns = self.segments();
        std::array::from_fn(|d| Digit::from_columns(columns[2 * d], columns[2 * d + 1]))
    }
}

/// Which way the bytes of a transaction go, seen from the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the chip.
    Write,
    /// From the chip.
    Read,
}

const A: u8 = 1 << 0;
const B: u8 = 1 << 1;
const C: u8 = 1 << 2;
const D: u8 = 1 << 3;
const E: u8 = 1 << 4;
const F: u8 = 1 << 5;
const G: u8 = 1 << 6;

/// What a reader makes of a digit. Where two characters look alike (0 and O, 5 and S) the digit
/// stands.
#[rustfmt::skip]
const GLYPHS: &[(u8, char)] = &[
    (0, ' '),
    (A | B | C | D | E | F, '0'), (B | C, '1'), (A | B | G | E | D, '2'), (A | B | C | D | G, '3'), (F | G | B | C, '4'),
    (A | F | G | C | D, '5'), (A | F | E | D | C | G, '6'), (A | B | C, '7'), (A | B | C | D | E | F | G, '8'), (A | B | C | D | F | G, '9'),
    (A | B | C | E | F | G, 'A'), (C | D | E | F | G, 'b'), (A | D | E | F, 'C'), (D | E | G, 'c'), (B | C | D | E | G, 'd'),
    (A | D | E | F | G, 'E'), (A | E | F | G, 'F'), (A | C | D | E | F, 'G'), (B | C | E | F | G, 'H'), (C | E | F | G, 'h'),
    (C, 'i'), (E | F, 'I'), (B | C | D, 'J'), (B | C | D | E, 'J'), (D | E | F, 'L'), (C | E | G, 'n'), (A | B | C | E | F, 'N'), (C | D | E | G, 'o'),
    (A | B | E | F | G, 'P'), (A | B | C | F | G, 'q'), (E | G, 'r'), (D | E | F | G, 't'), (B | C | D | E | F, 'U'), (C | D | E, 'u'),
    (B | C | D | F | G, 'y'), (G, '-'), (D, '_'), (A, '~'), (A | B | F | G, '°'), (D | G, '='), (A | D | G, '≡'),
];

impl Digit {
    fn from_columns(even: u8, odd: u8) -> Self {
        let wiring = [
            (even, 0b1000, A),
            (even, 0b0100, B),
            (even, 0b0010, C),
            (odd, 0b1000, F),
            (odd, 0b0100, G),
            (odd, 0b0010, E),
            (odd, 0b0001, D),
        ];
        let segments = wiring
            .into_iter()
            .filter(|(column, backplane, _)| column & backplane != 0)
            .fold(0, |segments, (_, _, segment)| segments | segment);
        Self { segments, point: even & 0b0001 != 0 }
    }

    /// `?` for what is no character.
    fn character(self) -> char {
        GLYPHS.iter().find(|(segments, _)| *segments == self.segments).map_or('?', |(_, c)| *c)
    }

    /// Row 0 to 2 of the picture, four characters.
    fn ascii(self, row: usize) -> String {
        let lit = |segment, sign| if self.segments & segment != 0 { sign } else { ' ' };
        let point = if self.point { '.' } else { ' ' };
        match row {
            0 => [' ', lit(A, '_'), ' ', ' '],
            1 => [lit(F, '|'), lit(G, '_'), lit(B, '|'), ' '],
            _ => [lit(E, '|'), lit(D, '_'), lit(C, '|'), point],
        }
        .into_iter()
        .collect()
    }
}

fn text(line: &[Digit]) -> String {
    let mut text = String::new();
    for digit in line {
        text.push(digit.character());
        if digit.point {
            text.push('.');
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use expect_test::{Expect, expect};

    const ENABLED: u8 = 0x48;
    const MORE: u8 = 0x80;

    fn transaction(chip: &mut LcdChip, bytes: &[u8]) {
        assert!(chip.start(ADDRESS, Direction::Write));
        bytes.iter().for_each(|&byte| chip.write(byte));
        chip.stop();
    }

    /// The 20 data bytes of a picture, written the way the wiring table reads.
    fn picture(columns: &[(usize, u8)]) -> [u8; 20] {
        let mut bytes = [0; 20];
        for &(column, nibble) in columns {
            bytes[column / 2] |= if column % 2 == 0 { nibble << 4 } else { nibble };
        }
        bytes
    }

    fn shown(data: &[u8]) -> LcdChip {
        let mut chip = LcdChip::default();
        let head = [MORE | ENABLED, MORE | 0x78, MORE | 0x70, MORE | 0x60, 0x00];
        transaction(&mut chip, &[&head[..], data].concat());
        chip
    }

    #[track_caller]
    fn check(chip: &LcdChip, expected: Expect) {
        let arrows = (chip.left_arrow(), chip.right_arrow());
        let text = format!("[{}] [{}] {arrows:?}", chip.upper(), chip.lower());
        expected.assert_eq(&format!("{text}\n{}", chip.ascii().replace(' ', "·")));
    }

    #[test]
    fn digits_points_and_arrows_are_where_the_wiring_puts_them() {
        // 1 2. in the first two places above, 8 in the last place below, both arrows.
        let data = picture(&[
            (0, 0b0110),
            (2, 0b1101),
            (3, 0b0111),
            (22, 0b1110),
            (23, 0b1111),
            (24, 0b1100),
        ]);
        check(
            &shown(&data),
            expect![[r#"
                [12.    ] [     8] (true, true)
                ······_···················
                ···|··_|··················
                ···|·|_·.·················
                ······················_···
                ·····················|_|··
                ·····················|_|··
                <························>
            "#]],
        );
    }

    #[test]
    fn a_disabled_or_wrongly_multiplexed_chip_shows_nothing() {
        for mode in [0x40, 0x49, 0x4C] {
            let mut chip = shown(&[0xFF; 20]);
            transaction(&mut chip, &[mode]);
            assert_eq!(chip.segments(), [0; COLUMNS], "mode-set {mode:#x}");
        }
        assert_eq!(LcdChip::default().segments(), [0; COLUMNS]);
    }

    #[test]
    fn data_starts_at_the_pointer_and_ends_with_the_chip() {
        let mut chip = shown(&[0; 20]);
        transaction(&mut chip, &[MORE | 0x60, 38, 0xFF, 0xFF]);
        let mut lit = [0; COLUMNS];
        lit[38..].fill(0xF);
        assert_eq!(chip.segments(), lit);
    }

    #[test]
    fn another_subaddress_or_address_is_not_this_chip() {
        let mut chip = shown(&[0; 20]);
        transaction(&mut chip, &[MORE | 0x61, 0x00, 0xFF]);
        assert_eq!(chip.segments(), [0; COLUMNS]);
        assert!(!chip.start(ADDRESS, Direction::Read));
        assert!(!chip.start(ADDRESS + 1, Direction::Write));
    }

    #[test]
    fn the_blink_command_is_seen() {
        let mut chip = LcdChip::default();
        transaction(&mut chip, &[0x72]);
        assert!(chip.blinking());
        transaction(&mut chip, &[0x70]);
        assert!(!chip.blinking());
    }

    #[test]
    fn glyphs_are_told_apart() {
        for (n, (segments, _)) in GLYPHS.iter().enumerate() {
            assert!(GLYPHS.iter().skip(n + 1).all(|(other, _)| other != segments));
        }
    }
}
