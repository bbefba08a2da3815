use super::identity::Part;
use super::settings::RequestLength;
use crate::frame::DATA_MAX;

/// What a master asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    SwitchToWaiting,
    SwitchToConfiguration,
    Select { part: Part, value: u32 },
    Identify { bound: Bound, value: u32 },
    IdentifyNonConfigured,
    Fastscan(Fastscan),
    ConfigureNodeId { node_id: u8 },
    ConfigureBitTiming { table: u8, index: u8 },
    ActivateBitTiming { delay_ms: u16 },
    Store,
    Inquire(Part),
    InquireNodeId,
}

/// What an identify frame says about the devices that are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bound {
    Vendor,
    Product,
    RevisionMin,
    RevisionMax,
    SerialMin,
    SerialMax,
}

/// One question of a fastscan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fastscan {
    /// Who takes part? The scan begins anew.
    Begin,
    /// Whose `part` equals `number` in bit 31 to bit `lowest_bit`? `next` is asked for afterwards.
    Compare { number: u32, lowest_bit: u8, part: Part, next: Part },
}

impl Request {
    /// `None` for frames that are no request, or not of the right length.
    pub(super) fn parse(data: &[u8], length: RequestLength) -> Option<Self> {
        let mut bytes = [0; DATA_MAX];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        let [command, a, b, c, d, e, f, g] = bytes;
        let value = u32::from_le_bytes([a, b, c, d]);
        let (request, needed) = match command {
            0x04 if a == 0 => (Self::SwitchToWaiting, 2),
            0x04 if a == 1 => (Self::SwitchToConfiguration, 2),
            0x11 => (Self::ConfigureNodeId { node_id: a }, 2),
            0x13 => (Self::ConfigureBitTiming { table: a, index: b }, 3),
            0x15 => (Self::ActivateBitTiming { delay_ms: u16::from_le_bytes([a, b]) }, 3),
            0x17 => (Self::Store, 1),
            0x40..=0x43 => (Self::Select { part: Part::from_number(command & 3)?, value }, 5),
            0x46 => (Self::Identify { bound: Bound::Vendor, value }, 5),
            0x47 => (Self::Identify { bound: Bound::Product, value }, 5),
            0x48 => (Self::Identify { bound: Bound::RevisionMin, value }, 5),
            0x49 => (Self::Identify { bound: Bound::RevisionMax, value }, 5),
            0x4A => (Self::Identify { bound: Bound::SerialMin, value }, 5),
            0x4B => (Self::Identify { bound: Bound::SerialMax, value }, 5),
            0x4C => (Self::IdentifyNonConfigured, 1),
            0x51 => (Self::Fastscan(fastscan(value, [e, f, g])?), 8),
            0x5A => (Self::Inquire(Part::Vendor), 1),
            0x5B => (Self::Inquire(Part::Product), 1),
            0x5C => (Self::Inquire(Part::Revision), 1),
            0x5D => (Self::Inquire(Part::Serial), 1),
            0x5E => (Self::InquireNodeId, 1),
            _ => return None,
        };
        let long_enough = match length {
            RequestLength::Eight => data.len() == DATA_MAX,
            RequestLength::AsNeeded => data.len() >= needed,
        };
        long_enough.then_some(request)
    }
}

fn fastscan(number: u32, [bit_check, sub, next]: [u8; 3]) -> Option<Fastscan> {
    const BEGIN: u8 = 0x80;
    match bit_check {
        BEGIN => Some(Fastscan::Begin),
        0..=31 => Some(Fastscan::Compare {
            number,
            lowest_bit: bit_check,
            part: Part::from_number(sub)?,
            next: Part::from_number(next)?,
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decision A-24, and the eight bytes of CiA 305.
    #[test]
    fn a_request_has_the_length_the_product_asks_for() {
        let frame = [0x13, 0, 2, 0, 0, 0, 0, 0];
        let request = Some(Request::ConfigureBitTiming { table: 0, index: 2 });
        for (dlc, eight, as_needed) in
            [(0, None, None), (2, None, None), (3, None, request), (8, request, request)]
        {
            assert_eq!(Request::parse(&frame[..dlc], RequestLength::Eight), eight, "{dlc}");
            assert_eq!(Request::parse(&frame[..dlc], RequestLength::AsNeeded), as_needed, "{dlc}");
        }
    }

    #[test]
    fn reserved_commands_and_arguments_are_no_requests() {
        for frame in [
            [0x04, 2, 0, 0, 0, 0, 0, 0],
            [0x44, 0, 0, 0, 0, 0, 0, 0],
            [0x4F, 0, 0, 0, 0, 0, 0, 0],
            [0x51, 0, 0, 0, 0, 32, 0, 0],
            [0x51, 0, 0, 0, 0, 31, 4, 0],
            [0x51, 0, 0, 0, 0, 31, 0, 4],
            [0x5F, 0, 0, 0, 0, 0, 0, 0],
        ] {
            assert_eq!(Request::parse(&frame, RequestLength::Eight), None, "{frame:02X?}");
        }
    }
}
