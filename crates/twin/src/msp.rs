//! The application controller: its core, and what the shell of the image does for it.

use application::{Application, Boot, Inputs, SSI_READ_LEN, STEP};
use lcd::pcf8576;
use profiles::Product;
use world::lcd_chip::{Direction, LcdChip};
use world::{MotorOutputs, Surroundings};

use crate::board::Board;
use crate::memory::Kept;
use crate::pair::Outgoing;

const STEP_NS: u64 = STEP.as_micros() * 1_000;
/// How often the picture is composed.
const STEPS_PER_PICTURE: u32 = 5;
/// Clocks of one read of the sensor, and how long one is: 625 kHz.
const SSI_CLOCKS: u8 = 32;
const SSI_PERIOD_NS: u64 = 1_600;

const _: () = assert!(SSI_CLOCKS as usize == 8 * SSI_READ_LEN);

/// The controller while it has supply.
#[derive(Debug)]
pub(crate) struct Msp {
    application: Box<Application>,
    next_step_ns: u64,
    steps: u32,
    shown: Option<[u8; pcf8576::RAM_LEN]>,
}

impl Msp {
    /// Starts with what `board` has in its memory.
    pub(crate) fn new(now_ns: u64, product: &'static Product, board: &Board) -> Self {
        let boot = Boot { nonce: board.nonce() };
        let application = Box::new(Application::new(product, boot, board.memory.numbers()));
        Self { application, next_step_ns: now_ns + STEP_NS, steps: 0, shown: None }
    }

    /// When there is something to do, apart from the line.
    pub(crate) fn due_ns(&self) -> u64 {
        self.next_step_ns
    }

    /// Does what is due: bytes, then the step.
    pub(crate) fn run(
        &mut self,
        arrived: Option<&[u8]>,
        world: &mut Surroundings,
        out: &mut Outgoing<'_>,
    ) -> Kept {
        let mut kept = Kept::Yes;
        if let Some(bytes) = arrived {
            self.application.handle_link(out.board.time(out.now_ns), bytes);
            kept = self.drain(world, out);
        }
        if self.next_step_ns <= out.now_ns {
            self.next_step_ns += STEP_NS;
            self.application.step(out.board.time(out.now_ns), &inputs(out.now_ns, world));
            self.steps = self.steps.wrapping_add(1);
            if self.steps.is_multiple_of(STEPS_PER_PICTURE) {
                self.refresh(&mut world.lcd);
            }
        }
        kept.and(self.drain(world, out))
    }

    /// Hands on what the core brought about: the motor first.
    fn drain(&mut self, world: &mut Surroundings, out: &mut Outgoing<'_>) -> Kept {
        let application::MotorOutputs { in1, in2, in3, in4 } = self.application.motor();
        let motor = MotorOutputs { in1, in2, in3, in4 };
        if motor != world.motor {
            world.drive_motor(out.now_ns, motor);
        }
        while out.has_room()
            && let Some(frame) = self.application.poll_link()
        {
            out.send(&frame);
        }
        let mut kept = Kept::Yes;
        while let Some((key, number)) = self.application.poll_store() {
            kept = kept.and(out.keep(key, number));
        }
        if self.application.restart_due() {
            out.restart();
        }
        kept
    }

    fn refresh(&mut self, lcd: &mut LcdChip) {
        let picture = self.application.picture();
        let before = self.shown.replace(picture);
        if before.is_none() {
            write(lcd, &pcf8576::INITIALISE);
        }
        if before != Some(picture) {
            write(lcd, &pcf8576::refresh(&picture));
        }
    }
}

fn write(lcd: &mut LcdChip, bytes: &[u8]) {
    if lcd.start(pcf8576::ADDRESS, Direction::Write) {
        bytes.iter().for_each(|byte| lcd.write(*byte));
    }
    lcd.stop();
}

fn inputs(now_ns: u64, world: &mut Surroundings) -> Inputs {
    let Surroundings { encoder, spindle, panel, .. } = world;
    Inputs {
        ssi: encoder.clock(now_ns, spindle, SSI_CLOCKS, SSI_PERIOD_NS).to_be_bytes(),
        left_key: panel.left_key,
        right_key: panel.right_key,
        input_f: panel.input_f,
        input_g: panel.input_g,
        motor_fault: false,
    }
}
