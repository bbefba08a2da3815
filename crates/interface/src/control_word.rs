//! The control word of RxPDO2 (manual 4.3.4.3; NM17x PDO-19 to PDO-24, A-43).

use object_dictionary::ObjectId;
use profiles::Equipment;
use profiles::nm17x::{
    SAW_IN_SETPOINT, SETPOINT_D3, STANDARD_SETPOINT, START_DIRECT_SETPOINT, START_SAW_IN_SETPOINT,
    START_STANDARD_SETPOINT,
};

/// Bits that mean nothing: the toggle bit, and the reserved ones.
const MEANINGFUL: u16 = 0x43FF;
const STOP: u16 = 1 << 14;

/// What a frame asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Nothing.
    Nothing,
    /// The motor is to stop; all other bits and bytes are ignored.
    Stop,
    /// Setpoint and correction are to be taken.
    Setpoint { object: ObjectId, saw_in_speed: Option<u32> },
    /// The motor is to run without a target: a code of 0x204D:03.
    Jog(u32),
    /// The clamp is to open or close: a code of 0x2048.
    Clamp(u32),
}

impl Order {
    /// The order of a control word. `None` for a combination that is not permitted on a device with
    /// this equipment.
    pub(crate) fn from_control_word(word: u16, equipment: Equipment) -> Option<Self> {
        let word = word & MEANINGFUL;
        if word == 0 {
            return Some(Self::Nothing);
        }
        if word & STOP != 0 {
            return Some(match equipment {
                Equipment::Nothing => Self::Nothing,
                Equipment::KeysAndMotor => Self::Stop,
            });
        }
        let row = ROWS.iter().find(|(mask, value, _)| word & mask == *value);
        let order = row.map(|(_, _, order)| *order)?;
        match equipment {
            Equipment::KeysAndMotor => Some(order),
            Equipment::Nothing => Some(order).filter(|order| *order == STANDARD),
        }
    }
}

const STANDARD: Order = setpoint(STANDARD_SETPOINT.id());

/// Mask, value, order: rows 1 and 4 to 20 of the manual.
const ROWS: [(u16, u16, Order); 18] = [
    (0x43E1, 0x0021, setpoint(SETPOINT_D3.id())),
    (0x43E7, 0x0007, setpoint(START_DIRECT_SETPOINT.id())),
    (0x43FF, 0x0001, STANDARD),
    (0x43FF, 0x0003, setpoint(START_STANDARD_SETPOINT.id())),
    (0x43FF, 0x0009, saw_in(SAW_IN_SETPOINT.id(), 0)),
    (0x43FF, 0x0011, saw_in(SAW_IN_SETPOINT.id(), 1)),
    (0x43FF, 0x0019, saw_in(SAW_IN_SETPOINT.id(), 2)),
    (0x43FF, 0x000B, saw_in(START_SAW_IN_SETPOINT.id(), 0)),
    (0x43FF, 0x0013, saw_in(START_SAW_IN_SETPOINT.id(), 1)),
    (0x43FF, 0x001B, saw_in(START_SAW_IN_SETPOINT.id(), 2)),
    (0x43FF, 0x0089, Order::Jog(11)),
    (0x43FF, 0x0091, Order::Jog(12)),
    (0x43FF, 0x0099, Order::Jog(13)),
    (0x43FF, 0x0109, Order::Jog(21)),
    (0x43FF, 0x0111, Order::Jog(22)),
    (0x43FF, 0x0119, Order::Jog(23)),
    (0x43FF, 0x0201, Order::Clamp(0)),
    (0x43FF, 0x0203, Order::Clamp(1)),
];

const fn setpoint(object: ObjectId) -> Order {
    Order::Setpoint { object, saw_in_speed: None }
}

const fn saw_in(object: ObjectId, speed: u32) -> Order {
    Order::Setpoint { object, saw_in_speed: Some(speed) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(word: u16) -> Option<Order> {
        Order::from_control_word(word, Equipment::KeysAndMotor)
    }

    /// NM17x PDO-19, PDO-20, PDO-21: what each row of the manual permits, and nothing else. The
    /// toggle bit and the reserved bits change nothing.
    #[test]
    fn every_permitted_word_has_its_order() {
        let counts = |order: Option<Order>| {
            (0..=u16::MAX)
                .filter(|word| {
                    super::Order::from_control_word(*word, Equipment::KeysAndMotor) == order
                })
                .count()
        };
        let free = 1 << 5;
        assert_eq!(counts(Some(Order::Nothing)), free);
        assert_eq!(counts(Some(Order::Stop)), 1 << 15);
        assert_eq!(counts(Some(setpoint(SETPOINT_D3.id()))), free << 4);
        assert_eq!(counts(Some(setpoint(START_DIRECT_SETPOINT.id()))), free << 2);
        for (_, word, expected) in ROWS.iter().skip(2) {
            assert_eq!(
                (order(*word), counts(Some(*expected))),
                (Some(*expected), free),
                "{word:#x}"
            );
        }
    }

    /// NM17x PDO-21, A-43: the reserved rows 2 and 3, enable 0 with other bits, two directions.
    #[test]
    fn all_others_have_none() {
        for word in [0x0041, 0x0061, 0x0002, 0x0080, 0x0181, 0x0081, 0x0205, 0x0005, 0x0301] {
            assert_eq!(order(word), None, "{word:#x}");
        }
    }

    /// NM17x A-38: without a motor.
    #[test]
    fn a_device_without_motor_takes_setpoints() {
        for (word, expected) in [
            (0x0000, Some(Order::Nothing)),
            (0x0001, Some(STANDARD)),
            (0x4001, Some(Order::Nothing)),
            (0x0003, None),
            (0x0021, None),
            (0x0089, None),
        ] {
            assert_eq!(Order::from_control_word(word, Equipment::Nothing), expected, "{word:#x}");
        }
    }
}
