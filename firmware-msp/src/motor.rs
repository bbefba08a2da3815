//! The four lines to the motor driver, active high. External pull-downs keep them low while the
//! controller is in reset; [`off`] is the first thing the program does with the pins, and the last.
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::pac::{GPIOD, GPIOE, GPIOF};
use embassy_stm32::peripherals::{PD15, PE9, PE11, PF12};

pub(crate) struct Pins {
    pub(crate) in1: Peri<'static, PE9>,
    pub(crate) in2: Peri<'static, PE11>,
    pub(crate) in3: Peri<'static, PF12>,
    pub(crate) in4: Peri<'static, PD15>,
}

pub(crate) struct Motor {
    lines: [Output<'static>; 4],
}

impl Motor {
    /// All lines off.
    pub(crate) fn new(pins: Pins) -> Self {
        Self {
            lines: [
                Output::new(pins.in1, Level::Low, Speed::Low),
                Output::new(pins.in2, Level::Low, Speed::Low),
                Output::new(pins.in3, Level::Low, Speed::Low),
                Output::new(pins.in4, Level::Low, Speed::Low),
            ],
        }
    }

    /// Sets IN1..IN4, those that go off first: no order of the writes lets two directions or speeds
    /// meet.
    pub(crate) fn drive(&mut self, lines: [bool; 4]) {
        for (line, on) in self.lines.iter_mut().zip(lines) {
            if !on {
                line.set_low();
            }
        }
        for (line, on) in self.lines.iter_mut().zip(lines) {
            if on {
                line.set_high();
            }
        }
    }
}

/// Switches the lines off whoever drives them: for a program that stops.
pub(crate) fn off() {
    GPIOE.bsrr().write(|w| {
        w.set_br(9, true);
        w.set_br(11, true);
    });
    GPIOF.bsrr().write(|w| w.set_br(12, true));
    GPIOD.bsrr().write(|w| w.set_br(15, true));
}
