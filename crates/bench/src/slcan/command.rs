//! One line of a client.
//!
//! The command set is the one of the LAWICEL CANUSB and CAN232 manuals, which slcand, the kernel's
//! slcan driver and python-can share.

use world::can::{Frame, Id};

use crate::hex;

/// What a line asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// An empty line: clients send some to clear what an earlier one left behind.
    Nothing,
    /// `Sn` and `sxxyy`: the bit rate, in bit/s.
    BitRate(u32),
    /// `O`: take part in the bus.
    Open,
    /// `L`: listen, without acknowledging.
    Listen,
    /// `C`: leave the bus.
    Close,
    /// `t`, `T`, `r`, `R`: send.
    Transmit(Frame),
    /// `V`: hardware and software version.
    Version,
    /// `v`: firmware version.
    Firmware,
    /// `N`: serial number.
    Serial,
    /// `F`: status flags.
    Status,
    /// `Z0`, `Z1`: whether received frames carry a time.
    Stamps(Stamps),
    /// `M`, `m`, `X`, `W`: acceptance filters and polling mode. Accepted without effect: every
    /// client gets every frame, unasked.
    Ignored,
}

/// Whether received frames carry a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamps {
    /// They do not.
    Off,
    /// Four digits: milliseconds, from 0 to 59 999 and round again.
    Milliseconds,
}

/// The line is no command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

/// `S0` to `S8`.
const BIT_RATES: [u32; 9] =
    [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];

impl Command {
    /// Reads a line, which comes without its carriage return.
    ///
    /// # Errors
    /// When no command looks like it.
    pub fn parse(line: &[u8]) -> Result<Self, Malformed> {
        let Some((&letter, rest)) = line.split_first() else {
            return Ok(Self::Nothing);
        };
        match (letter, rest) {
            (b'S', [digit @ b'0'..=b'8']) => {
                let rate = BIT_RATES.get(usize::from(digit - b'0')).ok_or(Malformed)?;
                Ok(Self::BitRate(*rate))
            }
            (b's', digits) => register_rate(digits).map(Self::BitRate).ok_or(Malformed),
            (b'O', []) => Ok(Self::Open),
            (b'L', []) => Ok(Self::Listen),
            (b'C', []) => Ok(Self::Close),
            (b't', rest) => data_frame(rest, STANDARD_DIGITS).map(Self::Transmit),
            (b'T', rest) => data_frame(rest, EXTENDED_DIGITS).map(Self::Transmit),
            (b'r', rest) => remote_frame(rest, STANDARD_DIGITS).map(Self::Transmit),
            (b'R', rest) => remote_frame(rest, EXTENDED_DIGITS).map(Self::Transmit),
            (b'V', []) => Ok(Self::Version),
            (b'v', []) => Ok(Self::Firmware),
            (b'N', []) => Ok(Self::Serial),
            (b'F', []) => Ok(Self::Status),
            (b'Z', [b'0']) => Ok(Self::Stamps(Stamps::Off)),
            (b'Z', [b'1']) => Ok(Self::Stamps(Stamps::Milliseconds)),
            (b'M' | b'm', digits @ [_, _, _, _, _, _, _, _]) => {
                hex::number(digits).map(|_| Self::Ignored).ok_or(Malformed)
            }
            (b'X', [b'0' | b'1']) | (b'W', [b'0'..=b'2']) => Ok(Self::Ignored),
            _ => Err(Malformed),
        }
    }
}

/// `xxyy`: bit timing registers of an SJA1000, whose time quantum is a multiple of 1/8 µs.
fn register_rate(digits: &[u8]) -> Option<u32> {
    const CLOCK_HZ: u32 = 8_000_000;
    let &[prescaler, timing] = hex::bytes(digits)?.as_slice() else { return None };
    let prescale = u32::from(prescaler & 0x3F) + 1;
    let quanta = 1 + u32::from(timing & 0x0F) + 1 + u32::from(timing >> 4 & 0x07) + 1;
    Some(CLOCK_HZ / (prescale * quanta))
}

/// Digits of an identifier of 11 bits.
const STANDARD_DIGITS: usize = 3;
/// Digits of an identifier of 29 bits.
const EXTENDED_DIGITS: usize = 8;

fn data_frame(text: &[u8], id_digits: usize) -> Result<Frame, Malformed> {
    let (id, dlc, data) = fields(text, id_digits)?;
    let data = hex::bytes(data).ok_or(Malformed)?;
    if data.len() != usize::from(dlc) {
        return Err(Malformed);
    }
    Frame::new(id, &data).map_err(|_| Malformed)
}

fn remote_frame(text: &[u8], id_digits: usize) -> Result<Frame, Malformed> {
    let (id, dlc, rest) = fields(text, id_digits)?;
    if !rest.is_empty() {
        return Err(Malformed);
    }
    Frame::remote(id, dlc).map_err(|_| Malformed)
}

fn fields(text: &[u8], id_digits: usize) -> Result<(Id, u8, &[u8]), Malformed> {
    let (id, rest) = text.split_at_checked(id_digits).ok_or(Malformed)?;
    let id = hex::number(id).ok_or(Malformed)?;
    let id = if id_digits == STANDARD_DIGITS {
        Id::Standard(u16::try_from(id).map_err(|_| Malformed)?)
    } else {
        Id::Extended(id)
    };
    let (&dlc, rest) = rest.split_first().ok_or(Malformed)?;
    if !dlc.is_ascii_digit() {
        return Err(Malformed);
    }
    Ok((id, dlc - b'0', rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn standard(id: u16, data: &[u8]) -> Result<Command, Malformed> {
        Ok(Command::Transmit(Frame::new(Id::Standard(id), data).unwrap()))
    }

    #[test]
    fn every_command_is_understood() {
        let extended =
            |id, data: &[u8]| Ok(Command::Transmit(Frame::new(Id::Extended(id), data).unwrap()));
        let remote = |id, dlc| Ok(Command::Transmit(Frame::remote(id, dlc).unwrap()));
        for (line, expected) in [
            ("", Ok(Command::Nothing)),
            ("S0", Ok(Command::BitRate(10_000))),
            ("S4", Ok(Command::BitRate(125_000))),
            ("S7", Ok(Command::BitRate(800_000))),
            ("S8", Ok(Command::BitRate(1_000_000))),
            ("s031C", Ok(Command::BitRate(125_000))),
            ("s0014", Ok(Command::BitRate(1_000_000))),
            ("O", Ok(Command::Open)),
            ("L", Ok(Command::Listen)),
            ("C", Ok(Command::Close)),
            ("t0002017F", standard(0, &[0x01, 0x7F])),
            ("t67F84018100000000000aF", Err(Malformed)),
            ("t67F840181000000000aF", standard(0x67F, &[0x40, 0x18, 0x10, 0, 0, 0, 0, 0xAF])),
            ("t7FF0", standard(0x7FF, &[])),
            ("t7ff1aB", standard(0x7FF, &[0xAB])),
            ("T1FFFFFFF2CafE", extended(0x1FFF_FFFF, &[0xCA, 0xFE])),
            ("r77F0", remote(Id::Standard(0x77F), 0)),
            ("r77F8", remote(Id::Standard(0x77F), 8)),
            ("R000000011", remote(Id::Extended(1), 1)),
            ("V", Ok(Command::Version)),
            ("v", Ok(Command::Firmware)),
            ("N", Ok(Command::Serial)),
            ("F", Ok(Command::Status)),
            ("Z0", Ok(Command::Stamps(Stamps::Off))),
            ("Z1", Ok(Command::Stamps(Stamps::Milliseconds))),
            ("M00000000", Ok(Command::Ignored)),
            ("mFFFFFFFF", Ok(Command::Ignored)),
            ("X1", Ok(Command::Ignored)),
        ] {
            assert_eq!(Command::parse(line.as_bytes()), expected, "{line:?}");
        }
    }

    #[test]
    fn what_is_no_command_is_refused() {
        for line in [
            "S",
            "S9",
            "S44",
            "SA",
            "s",
            "s03",
            "s031",
            "s031C0",
            "sXXXX",
            "OO",
            "O ",
            "Lx",
            "C1",
            "t",
            "t7",
            "t7FF",
            "t8000",
            "tFFF0",
            "t7FF9",
            "t7FF9001122334455667788",
            "t7FF1",
            "t7FF1A",
            "t7FF1AABB",
            "t7FF0AA",
            "t7FF1G0",
            "t+FF0",
            "T7FF0",
            "T200000000",
            "r8000",
            "r77F9",
            "r77F100",
            "R0000001",
            "V1",
            "N0",
            "FF",
            "Z",
            "Z2",
            "M0",
            "m000000000",
            "MXXXXXXXX",
            "X",
            "X2",
            "Q",
            "\u{7}",
            "d7FF0",
            "hello",
        ] {
            assert_eq!(Command::parse(line.as_bytes()), Err(Malformed), "{line:?}");
        }
    }
}
