//! Keys, external inputs and the fault line of the motor driver.
//!
//! Read once per step: the levels are bounced and debounced by the core, which knows how long a
//! press has to last.
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::peripherals::{PD14, PE13, PF13, PF14, PF15};

pub(crate) struct Pins {
    pub(crate) left: Peri<'static, PF13>,
    pub(crate) right: Peri<'static, PF14>,
    pub(crate) input_f: Peri<'static, PF15>,
    pub(crate) input_g: Peri<'static, PE13>,
    pub(crate) motor_fault: Peri<'static, PD14>,
}

pub(crate) struct Panel {
    left: Input<'static>,
    right: Input<'static>,
    input_f: Input<'static>,
    input_g: Input<'static>,
    motor_fault: Input<'static>,
}

/// The levels as they mean: a key is down, an input is on, the motor driver reports a fault.
#[derive(Clone, Copy)]
pub(crate) struct Levels {
    pub(crate) left: bool,
    pub(crate) right: bool,
    pub(crate) input_f: bool,
    pub(crate) input_g: bool,
    pub(crate) motor_fault: bool,
}

impl Panel {
    pub(crate) fn new(pins: Pins) -> Self {
        Self {
            left: Input::new(pins.left, Pull::Up),
            right: Input::new(pins.right, Pull::Up),
            input_f: Input::new(pins.input_f, Pull::Down),
            input_g: Input::new(pins.input_g, Pull::Down),
            motor_fault: Input::new(pins.motor_fault, Pull::Down),
        }
    }

    pub(crate) fn read(&self) -> Levels {
        Levels {
            left: self.left.is_low(),
            right: self.right.is_low(),
            input_f: self.input_f.is_high(),
            input_g: self.input_g.is_high(),
            motor_fault: self.motor_fault.is_high(),
        }
    }
}
