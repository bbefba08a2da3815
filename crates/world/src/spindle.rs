//! The shaft, turned by hand and by the motor.
//!
//! The position is counted in **sensor steps of 1/4096 turn** and is an exact function of virtual
//! time: nothing here runs in steps, so a reading taken at any nanosecond is the same whatever
//! else the bench looked at before. Turning right counts up.
//!
//! The motor understands the four lines as `NM17x A-65` has them: IN1 left, IN2 right, IN3 and IN4
//! the speed (01 slow, 10 middle, 11 fast). Both speed lines off is the closed clamp and both
//! directions on is the holding torque: the shaft stands in either case (`NM17x MOTOR-12`,
//! `MOTOR-13`).
use crate::MotorOutputs;

/// Sensor steps per turn: 12 bit angle.
pub const STEPS_PER_TURN: u32 = 1 << 12;

/// Values the sensor can tell apart: 13 bit turns and 12 bit angle.
pub const SENSOR_RANGE: u32 = 1 << 25;

/// What the sensor reads at position 0: turn 4096, angle 0, so that the shaft can be turned half
/// the range either way.
pub const RAW_AT_START: u32 = SENSOR_RANGE / 2;

const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// The shaft and what turns it.
#[derive(Clone, Debug, Default)]
pub struct Spindle {
    /// Steps × 10⁹ at `since_ns`.
    origin_nanosteps: i128,
    since_ns: u64,
    hand_steps_per_s: i64,
    motion: Motion,
    outputs: MotorOutputs,
    model: MotorModel,
}

/// What the motor does to the shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Motion {
    #[default]
    Still,
    Driven {
        steps_per_s: i64,
    },
    /// Switched off, and not standing yet.
    RunningOut {
        steps_per_s: i64,
        until_ns: u64,
    },
}

/// How the motor behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotorModel {
    /// Steps per second at IN3 alone.
    pub slow: u32,
    /// Steps per second at IN4 alone.
    pub middle: u32,
    /// Steps per second at IN3 and IN4.
    pub fast: u32,
    /// Steps the shaft still turns after the motor was switched off.
    pub run_out: u32,
    /// The motor does not get the shaft to move.
    pub stuck: bool,
    /// The direction lines are swapped.
    pub reversed: bool,
    /// The motor reports a fault on its OUT line. Whether it still turns is the other fields'
    /// business.
    pub fault: bool,
}

impl Default for MotorModel {
    /// 15, 60 and 240 turns per minute; stops on the spot.
    fn default() -> Self {
        Self {
            slow: 1_024,
            middle: 4_096,
            fast: 16_384,
            run_out: 0,
            stuck: false,
            reversed: false,
            fault: false,
        }
    }
}

impl Spindle {
    /// The position at `at_ns`, in sensor steps from where the shaft stood at the start, rounded
    /// down. Not limited: the sensor wraps, the shaft does not.
    #[must_use]
    pub fn position(&self, at_ns: u64) -> i64 {
        let steps = self.nanosteps(at_ns).div_euclid(NANOS_PER_SECOND);
        i64::try_from(steps).unwrap_or(if steps < 0 { i64::MIN } else { i64::MAX })
    }

    /// What the sensor measures at `at_ns`: 0 to [`SENSOR_RANGE`] − 1, binary.
    #[must_use]
    pub fn raw(&self, at_ns: u64) -> u32 {
        let raw = (i128::from(self.position(at_ns)) + i128::from(RAW_AT_START))
            .rem_euclid(i128::from(SENSOR_RANGE));
        u32::try_from(raw).expect("a remainder of SENSOR_RANGE fits")
    }

    /// The speed at `at_ns` in steps per second, right positive: hand and motor together.
    #[must_use]
    pub fn steps_per_s(&self, at_ns: u64) -> i64 {
        let motor = match self.motion {
            Motion::Driven { steps_per_s } => steps_per_s,
            Motion::RunningOut { steps_per_s, until_ns } if at_ns < until_ns => steps_per_s,
            Motion::RunningOut { .. } | Motion::Still => 0,
        };
        self.hand_steps_per_s.saturating_add(motor)
    }

    /// Turns the shaft by `steps` at once, right positive.
    pub fn turn(&mut self, steps: i64) {
        self.origin_nanosteps += i128::from(steps) * NANOS_PER_SECOND;
    }

    /// Turns the shaft by hand at a constant `steps_per_s` from `at_ns` on; 0 lets go.
    pub fn turn_steadily(&mut self, at_ns: u64, steps_per_s: i64) {
        self.rebase(at_ns);
        self.hand_steps_per_s = steps_per_s;
    }

    /// The motor sees `outputs` from `at_ns` on.
    pub fn drive(&mut self, at_ns: u64, outputs: MotorOutputs) {
        self.outputs = outputs;
        self.follow(at_ns);
    }

    /// How the motor behaves.
    #[must_use]
    pub const fn model(&self) -> MotorModel {
        self.model
    }

    /// Gives the motor another behaviour from `at_ns` on.
    pub fn set_model(&mut self, at_ns: u64, model: MotorModel) {
        self.model = model;
        self.follow(at_ns);
    }

    fn follow(&mut self, at_ns: u64) {
        self.rebase(at_ns);
        let wanted = self.model.steps_per_s(self.outputs);
        self.motion = match (wanted, self.motion) {
            (0, Motion::Driven { steps_per_s }) if !self.model.stuck => {
                run_out(at_ns, steps_per_s, self.model.run_out)
            }
            (0, Motion::RunningOut { .. }) if !self.model.stuck => self.motion,
            (0, Motion::Driven { .. } | Motion::RunningOut { .. } | Motion::Still) => Motion::Still,
            (steps_per_s, _) => Motion::Driven { steps_per_s },
        };
    }

    fn rebase(&mut self, at_ns: u64) {
        self.origin_nanosteps = self.nanosteps(at_ns);
        self.since_ns = self.since_ns.max(at_ns);
        if let Motion::RunningOut { until_ns, .. } = self.motion
            && until_ns <= at_ns
        {
            self.motion = Motion::Still;
        }
    }

    fn nanosteps(&self, at_ns: u64) -> i128 {
        let span = i128::from(at_ns.saturating_sub(self.since_ns));
        let motor = match self.motion {
            Motion::Still => 0,
            Motion::Driven { steps_per_s } => i128::from(steps_per_s) * span,
            Motion::RunningOut { steps_per_s, until_ns } => {
                let left = i128::from(until_ns.saturating_sub(self.since_ns));
                i128::from(steps_per_s) * span.min(left)
            }
        };
        self.origin_nanosteps + i128::from(self.hand_steps_per_s) * span + motor
    }
}

fn run_out(at_ns: u64, steps_per_s: i64, steps: u32) -> Motion {
    if steps == 0 {
        return Motion::Still;
    }
    let nanos = u128::from(steps) * 1_000_000_000 / u128::from(steps_per_s.unsigned_abs().max(1));
    let until_ns = at_ns.saturating_add(u64::try_from(nanos).unwrap_or(u64::MAX));
    Motion::RunningOut { steps_per_s, until_ns }
}

impl MotorModel {
    fn steps_per_s(self, lines: MotorOutputs) -> i64 {
        let speed = match (lines.in4, lines.in3) {
            (false, false) => 0,
            (false, true) => self.slow,
            (true, false) => self.middle,
            (true, true) => self.fast,
        };
        let right = match (lines.in1, lines.in2) {
            (false, true) => i64::from(speed),
            (true, false) => -i64::from(speed),
            (false, false) | (true, true) => 0,
        };
        match (self.stuck, self.reversed) {
            (true, _) => 0,
            (false, false) => right,
            (false, true) => -right,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;
    const RIGHT_SLOW: MotorOutputs = MotorOutputs { in1: false, in2: true, in3: true, in4: false };
    const LEFT_FAST: MotorOutputs = MotorOutputs { in1: true, in2: false, in3: true, in4: true };
    const OFF: MotorOutputs = MotorOutputs { in1: false, in2: false, in3: false, in4: false };

    #[test]
    fn the_position_is_an_exact_function_of_time() {
        let mut shaft = Spindle::default();
        shaft.turn_steadily(0, 3);
        assert_eq!(shaft.position(SECOND - 1), 2);
        assert_eq!(shaft.position(SECOND), 3);
        for at in 1..1_000 {
            shaft.turn_steadily(at * 7_777_777, 3);
        }
        assert_eq!(shaft.position(1_000 * SECOND), 3_000);
    }

    #[test]
    fn the_sensor_wraps_and_the_shaft_does_not() {
        let mut shaft = Spindle::default();
        assert_eq!(shaft.raw(0), RAW_AT_START);
        shaft.turn(i64::from(RAW_AT_START));
        assert_eq!((shaft.raw(0), shaft.position(0)), (0, 1 << 24));
        shaft.turn(-1);
        assert_eq!(shaft.raw(0), SENSOR_RANGE - 1);
    }

    #[test]
    fn the_motor_turns_as_its_lines_say() {
        for (lines, steps) in [
            (RIGHT_SLOW, 1_024),
            (LEFT_FAST, -16_384),
            (OFF, 0),
            (MotorOutputs { in1: true, in2: true, in3: true, in4: true }, 0),
            (MotorOutputs { in2: true, ..OFF }, 0),
        ] {
            let mut shaft = Spindle::default();
            shaft.drive(0, lines);
            assert_eq!(shaft.position(SECOND), steps, "{lines:?}");
        }
    }

    #[test]
    fn a_switched_off_motor_runs_out_and_stands() {
        let mut shaft = Spindle::default();
        shaft.set_model(0, MotorModel { run_out: 100, ..MotorModel::default() });
        shaft.drive(0, RIGHT_SLOW);
        shaft.drive(SECOND, OFF);
        assert!(shaft.steps_per_s(SECOND) > 0);
        assert_eq!(shaft.position(2 * SECOND), 1_024 + 100);
        assert_eq!(shaft.steps_per_s(2 * SECOND), 0);
    }

    #[test]
    fn a_stuck_or_reversed_motor_shows() {
        let mut shaft = Spindle::default();
        shaft.drive(0, RIGHT_SLOW);
        shaft.set_model(SECOND, MotorModel { stuck: true, ..MotorModel::default() });
        assert_eq!(shaft.position(9 * SECOND), 1_024);
        shaft.set_model(9 * SECOND, MotorModel { reversed: true, ..MotorModel::default() });
        assert_eq!(shaft.position(10 * SECOND), 0);
    }
}
