//! The PCF8576 family of display drivers on I²C: one chip with 40 segment outputs and four
//! backplanes, written and never read.
//!
//! The wiring of the glass, output S by backplane BP:
//!
//! ```text
//! S           BP0        BP1         BP2   BP3
//! 2d          a          b           c     point     d = 0 … 5 upper line, left to right
//! 2d + 1      f          g           e     d         d = 6 … 11 lower line, left to right
//! 24          left arrow right arrow
//! ```
//!
//! The display memory takes two outputs per byte, the even one in the upper half, BP0 first. Every
//! command byte but the last before the data has its top bit set.

use crate::glyph::Glyph;
use crate::view::View;

/// I²C address of the chip, 7 bits.
pub const ADDRESS: u8 = 0x38;
/// Bytes of the display memory.
pub const RAM_LEN: usize = 20;
/// Bytes of a [`refresh`].
pub const REFRESH_LEN: usize = 2 + RAM_LEN;

const MORE_COMMANDS: u8 = 1 << 7;
/// Display on, bias 1/3, four backplanes.
const MODE_SET: u8 = 0b100_1000;
/// Chip with subaddress 0.
const DEVICE_SELECT: u8 = 0b110_0000;
/// No bank switching; it exists for fewer backplanes only.
const BANK_SELECT: u8 = 0b111_1000;
/// The chip does not blink.
const BLINK_OFF: u8 = 0b111_0000;
/// The next data byte goes to the first outputs.
const LOAD_DATA_POINTER: u8 = 0;

const ARROWS_BYTE: usize = 12;
const LEFT_ARROW: u8 = 1 << 7;
const RIGHT_ARROW: u8 = 1 << 6;

const _: () = assert!(2 * crate::line::DIGITS <= ARROWS_BYTE && ARROWS_BYTE < RAM_LEN);

/// What to send after power-up of the chip and whenever it did not answer. A [`refresh`] follows.
pub const INITIALISE: [u8; 5] = [
    MODE_SET | MORE_COMMANDS,
    DEVICE_SELECT | MORE_COMMANDS,
    BANK_SELECT | MORE_COMMANDS,
    BLINK_OFF | MORE_COMMANDS,
    LOAD_DATA_POINTER,
];

/// What to send to show a picture.
#[must_use]
pub const fn refresh(ram: &[u8; RAM_LEN]) -> [u8; REFRESH_LEN] {
    let mut bytes = [0; REFRESH_LEN];
    let (commands, data) = bytes.split_at_mut(REFRESH_LEN - RAM_LEN);
    commands.copy_from_slice(&[DEVICE_SELECT | MORE_COMMANDS, LOAD_DATA_POINTER]);
    data.copy_from_slice(ram);
    bytes
}

impl View {
    /// The picture in the memory of the chip.
    #[must_use]
    pub fn ram(&self) -> [u8; RAM_LEN] {
        let mut ram = [0; RAM_LEN];
        let glyphs = self.upper.glyphs.iter().chain(&self.lower.glyphs);
        for (byte, glyph) in ram.iter_mut().zip(glyphs) {
            *byte = digit_byte(*glyph);
        }
        if let Some(byte) = ram.get_mut(ARROWS_BYTE) {
            let left = if self.arrows.left { LEFT_ARROW } else { 0 };
            let right = if self.arrows.right { RIGHT_ARROW } else { 0 };
            *byte = left | right;
        }
        ram
    }
}

/// The outputs 2d and 2d + 1, first bit first.
fn digit_byte(glyph: Glyph) -> u8 {
    [Glyph::A, Glyph::B, Glyph::C, Glyph::POINT, Glyph::F, Glyph::G, Glyph::E, Glyph::D]
        .iter()
        .fold(0, |byte, segment| byte << 1 | u8::from(glyph.shows(*segment)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::Line;
    use crate::view::Arrows;

    /// NM17x DISP-01: two lines of six digits and two arrows.
    #[test]
    fn every_segment_has_its_place() {
        for (text, arrows, expected) in [
            ("", Arrows::NONE, [0; RAM_LEN]),
            ("8.", Arrows::NONE, [0xFF, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
            (
                "172.A01",
                Arrows { left: true, right: false },
                [0x60, 0xE0, 0xD7, 0xEE, 0xEB, 0x60, 0, 0, 0, 0, 0, 0, 0x80, 0, 0, 0, 0, 0, 0, 0],
            ),
            (
                "34569-",
                Arrows { left: false, right: true },
                [0xE5, 0x6C, 0xAD, 0xAF, 0xED, 0x04, 0, 0, 0, 0, 0, 0, 0x40, 0, 0, 0, 0, 0, 0, 0],
            ),
        ] {
            let view = View { upper: Line::text(text.as_bytes()), lower: Line::BLANK, arrows };
            assert_eq!(view.ram(), expected, "{text}");
        }
        let lower = View { lower: Line::text(b"1    8"), ..View::default() };
        assert_eq!(lower.ram()[6..12], [0x60, 0, 0, 0, 0, 0xEF]);
    }

    #[test]
    fn commands_announce_the_next_one() {
        assert_eq!(INITIALISE, [0xC8, 0xE0, 0xF8, 0xF0, 0x00]);
        let bytes = refresh(&[0x5A; RAM_LEN]);
        assert_eq!(bytes[..2], [0xE0, 0x00]);
        assert_eq!(bytes[2..], [0x5A; RAM_LEN]);
    }
}
