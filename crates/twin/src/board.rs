//! What a controller has besides its core: supply, clock, memory.

use std::num::NonZeroU32;

use units::Instant;
use world::{EngineError, FlashImage, McuStats, Reset};

use crate::memory::Memory;

const NANOS_PER_MICRO: u64 = 1_000;

/// Why a controller starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// The supply came.
    PowerOn,
    /// The core asked for it.
    Software,
}

impl Cause {
    const fn name(self) -> &'static str {
        match self {
            Self::PowerOn => "power-on",
            Self::Software => "software",
        }
    }
}

/// One controller without its core.
#[derive(Debug)]
pub(crate) struct Board {
    /// Kept without supply.
    pub(crate) memory: Memory,
    /// When the core wants to restart, in nanoseconds.
    pub(crate) restart_at_ns: Option<u64>,
    started_ns: u64,
    starts: NonZeroU32,
    resets: Vec<Reset>,
}

impl Board {
    /// Without supply; with the memory `kept` from an earlier run.
    ///
    /// # Errors
    /// When `kept` is not this engine's.
    pub(crate) fn new(kept: Option<&FlashImage>) -> Result<Self, EngineError> {
        let memory = kept.map_or_else(|| Ok(Memory::default()), |kept| Memory::from_image(kept))?;
        Ok(Self {
            memory,
            restart_at_ns: None,
            started_ns: 0,
            starts: NonZeroU32::MIN,
            resets: Vec::new(),
        })
    }

    /// The controller starts: its clock and what it counts in RAM begin anew, or go on.
    pub(crate) fn start(&mut self, at_ns: u64, cause: Cause) {
        self.starts = match cause {
            Cause::PowerOn => NonZeroU32::MIN,
            Cause::Software => self.starts.saturating_add(1),
        };
        self.started_ns = at_ns;
        self.restart_at_ns = None;
        let at = Instant::from_micros(at_ns / NANOS_PER_MICRO);
        self.resets.push(Reset { at, cause: cause.name().to_owned() });
    }

    /// Tells one start from the next while there is supply.
    pub(crate) fn nonce(&self) -> NonZeroU32 {
        self.starts
    }

    /// The time as the controller counts it.
    pub(crate) fn time(&self, at_ns: u64) -> Instant {
        Instant::from_micros(at_ns.saturating_sub(self.started_ns) / NANOS_PER_MICRO)
    }

    /// When it is `time` on the controller's clock, in nanoseconds.
    pub(crate) fn nanos(&self, time: Instant) -> u64 {
        self.started_ns.saturating_add(time.as_micros().saturating_mul(NANOS_PER_MICRO))
    }

    /// The figures there are.
    pub(crate) fn stats(&self) -> McuStats {
        McuStats {
            resets: self.resets.clone(),
            flash_ops: self.memory.operations(),
            ..McuStats::default()
        }
    }
}
