//! One look at a device, for a terminal to draw.

use units::Instant;
use world::can::{Faults, LogCursor, Logged};
use world::lcd_chip::COLUMNS;
use world::{Link, LogLine, MotorOutputs, Panel};

use crate::stage::Stage;

/// Log lines in a look.
pub const LINES_SHOWN: usize = 32;

/// Everything a terminal shows.
#[derive(Clone, Debug)]
pub struct Glance {
    /// Virtual time.
    pub now: Instant,
    /// Virtual seconds per second of the wall clock.
    pub factor: f64,
    /// Whether the supply is switched on.
    pub powered: bool,
    /// Segments of the glass, one nibble per column.
    pub segments: [u8; COLUMNS],
    /// Keys and inputs.
    pub panel: Panel,
    /// Motor lines.
    pub motor: MotorOutputs,
    /// Speed of the shaft in sensor steps per second, right positive.
    pub steps_per_s: i64,
    /// What the sensor measures.
    pub raw: u32,
    /// Faults of the line between the controllers.
    pub link: Link,
    /// Faults of the bus.
    pub faults: Faults,
    /// Frames that failed since the start.
    pub error_frames: u64,
    /// Frames since the last look.
    pub frames: Vec<Logged>,
    /// Where the next look goes on.
    pub next: LogCursor,
    /// The newest log lines.
    pub log: Vec<LogLine>,
    /// Why the run can not go on.
    pub failure: Option<String>,
}

impl Glance {
    /// Looks at device `node`.
    #[must_use]
    pub fn take(stage: &Stage, node: usize, since: LogCursor, factor: f64) -> Self {
        let now_ns = stage.now_ns();
        let bus = stage.engine.bus();
        let (frames, next) = bus.log_since(since);
        let (faults, error_frames) = (bus.faults(), bus.error_frames());
        drop(bus);
        let around = stage.engine.surroundings(node);
        Self {
            now: stage.engine.now(),
            factor,
            powered: stage.powered(node),
            segments: around.lcd.segments(),
            panel: around.panel,
            motor: around.motor,
            steps_per_s: around.spindle.steps_per_s(now_ns),
            raw: around.spindle.raw(now_ns),
            link: around.link,
            faults,
            error_frames,
            frames,
            next,
            log: stage.logs.get(node).map(|book| book.newest(LINES_SHOWN)).unwrap_or_default(),
            failure: stage.failure().map(ToString::to_string),
        }
    }
}
