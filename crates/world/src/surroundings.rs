use crate::dice::Dice;
use crate::lcd_chip::LcdChip;
use crate::spindle::Spindle;
use crate::ssi_encoder::SsiEncoder;

/// Bits of a byte on the line between the controllers: start, eight data bits, stop.
const LINK_FRAME_BITS: u8 = 10;

/// Everything one device is wired to, apart from the CAN bus.
#[derive(Debug, Default)]
pub struct Surroundings {
    /// Shaft, with the motor that turns it.
    pub spindle: Spindle,
    /// The sensor on the shaft.
    pub encoder: SsiEncoder,
    /// Keys and inputs.
    pub panel: Panel,
    /// The display driver chip and its glass.
    pub lcd: LcdChip,
    /// The serial line between the controllers.
    pub link: Link,
    /// What the application controller drives: read it here, change it with
    /// [`Surroundings::drive_motor`].
    pub motor: MotorOutputs,
}

/// Keys and external inputs. `true`: pressed, active.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Panel {
    /// Left front key.
    pub left_key: bool,
    /// Right front key.
    pub right_key: bool,
    /// Input F (KEY 1 of the motor cable).
    pub input_f: bool,
    /// Input G (KEY 2 of the motor cable).
    pub input_g: bool,
}

/// The motor lines as driven. `true` is the active, high level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorOutputs {
    /// Left.
    pub in1: bool,
    /// Right.
    pub in2: bool,
    /// Speed bit 1.
    pub in3: bool,
    /// Speed bit 2.
    pub in4: bool,
}

/// Faults of the line between the controllers, both directions alike.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    /// No byte passes.
    pub cut: bool,
    /// Probability that a bit of a byte arrives inverted, 0 to 1.
    pub bit_error_rate: f64,
    /// Probability that a byte does not arrive, 0 to 1.
    pub drop_rate: f64,
}

impl Link {
    /// What arrives of a byte; `None` when nothing does. A disturbed start or stop bit loses the byte.
    #[must_use]
    pub fn carry(&self, value: u8, dice: &mut Dice) -> Option<u8> {
        if self.cut || dice.hits(self.drop_rate) {
            return None;
        }
        (0..LINK_FRAME_BITS).filter(|_| dice.hits(self.bit_error_rate)).try_fold(
            value,
            |value, bit| {
                let flipped = 1_u8.checked_shl(u32::from(bit.checked_sub(1)?))?;
                Some(value ^ flipped)
            },
        )
    }
}

impl Surroundings {
    /// The supply is gone: the display is dark and the motor lines have no driver.
    pub fn lose_power(&mut self, at_ns: u64) {
        self.lcd = LcdChip::default();
        self.drive_motor(at_ns, MotorOutputs::default());
    }

    /// The application controller drives `outputs` from `at_ns` on.
    pub fn drive_motor(&mut self, at_ns: u64, outputs: MotorOutputs) {
        self.motor = outputs;
        self.spindle.drive(at_ns, outputs);
    }
}
