//! The task that owns the core: a step every 2 ms, and the link's bytes as they come.
//!
//! Between two inputs the executor waits for an event with the core's clock off (WFE).
use application::{Application, Inputs, STEP};
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Ticker};
use firmware_board::{Beat, LinkReceiver, Outbox, RecordQueue};
use units::Instant;

use crate::display::{self, Picture};
use crate::encoder::{self, Encoder};
use crate::motor::Motor;
use crate::panel::Panel;

/// Bytes taken out of the link's ring at once.
const CHUNK_LEN: usize = 64;
/// How often the picture is composed: the display shows a turn of the shaft within 20 ms.
const STEPS_PER_PICTURE: u32 = 5;

const _: () = {
    assert!(STEPS_PER_PICTURE as u64 * STEP.as_micros() <= 10_000);
    assert!(embassy_time::TICK_HZ == 1_000_000);
    assert!(encoder::READ_LEN == application::SSI_READ_LEN);
};

/// The core's task is alive.
pub(crate) static BEAT: Beat = Beat::new();
/// Frames for the interface controller.
pub(crate) static TO_INTERFACE: Outbox = Outbox::new();
/// What the core wants stored.
pub(crate) static RECORDS: RecordQueue = RecordQueue::new();

/// What the core's task owns.
pub(crate) struct Core {
    pub(crate) application: Application,
    pub(crate) encoder: Encoder,
    pub(crate) panel: Panel,
    pub(crate) motor: Motor,
    pub(crate) from_interface: LinkReceiver,
}

impl Core {
    pub(crate) async fn run(mut self) -> ! {
        let mut steps = Ticker::every(Duration::from_micros(STEP.as_micros()));
        let mut chunk = [0; CHUNK_LEN];
        let mut shown = None;
        let mut steps_taken: u32 = 0;
        loop {
            // Both may be given up without losing anything: the ticker keeps its phase, and the
            // bytes stay in the ring.
            match select(steps.next(), self.from_interface.read(&mut chunk)).await {
                Either::First(()) => {
                    self.step().await;
                    steps_taken = steps_taken.wrapping_add(1);
                    if steps_taken.is_multiple_of(STEPS_PER_PICTURE) {
                        self.refresh(&mut shown);
                    }
                    BEAT.show();
                }
                Either::Second(Ok(len)) => {
                    let bytes = chunk.get(..len).unwrap_or(&chunk);
                    self.application.handle_link(now(), bytes);
                }
                // Damaged bytes are the core's to miss: every frame carries its check sum.
                Either::Second(Err(_)) => {}
            }
            self.drain();
        }
    }

    async fn step(&mut self) {
        let levels = self.panel.read();
        let inputs = Inputs {
            // A read that failed looks like a sensor that holds its line low all the time.
            ssi: self.encoder.read().await.unwrap_or_default(),
            left_key: levels.left,
            right_key: levels.right,
            input_f: levels.input_f,
            input_g: levels.input_g,
            motor_fault: levels.motor_fault,
        };
        self.application.step(now(), &inputs);
    }

    /// Hands on what the core brought about: the motor first.
    fn drain(&mut self) {
        let motor = self.application.motor();
        self.motor.drive([motor.in1, motor.in2, motor.in3, motor.in4]);
        while !TO_INTERFACE.is_full()
            && let Some(frame) = self.application.poll_link()
        {
            // There is room, and nobody else puts anything in.
            let _ = TO_INTERFACE.try_send(frame);
        }
        while let Some((key, number)) = self.application.poll_store() {
            RECORDS.put(key, number);
        }
        if self.application.restart_due() {
            RECORDS.restart();
        }
    }

    fn refresh(&self, shown: &mut Option<Picture>) {
        let picture = self.application.picture();
        if shown.replace(picture) != Some(picture) {
            display::show(picture);
        }
    }
}

/// The time as the core counts it.
fn now() -> Instant {
    Instant::from_micros(embassy_time::Instant::now().as_micros())
}
