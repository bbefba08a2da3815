//! The shaft as the sensor reports it, with disturbed and missing reads bridged.

use positioning::encoder::{Encoder, NM17X, TurnOffset};
use positioning::filter::{self, Filter};
use positioning::ssi::{Code, Format};
use units::Steps;

const ENCODER: Encoder = NM17X;
const FORMAT: Format = Format::new(ENCODER.bits(), Code::Gray);
/// Bytes to clock in for one read of the sensor.
pub const SSI_READ_LEN: usize = FORMAT.read_len();
/// Reads in a row that fail before the position counts as lost (NM17x A-107).
const FAULTS_MAX: u8 = 3;

/// What is known of the shaft.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sensor {
    filter: Filter,
    word: Option<u32>,
    faults: u8,
}

impl Sensor {
    /// Takes one read in.
    pub(crate) fn step(
        self,
        read: &[u8; SSI_READ_LEN],
        offset: TurnOffset,
        params: &filter::Params,
    ) -> Self {
        match FORMAT.decode(read) {
            Ok(word) => {
                let (filter, _) = self.filter.step(ENCODER.steps(word, offset), params);
                Self { filter, word: Some(word), faults: 0 }
            }
            Err(_) => Self { faults: self.faults.saturating_add(1).min(FAULTS_MAX), ..self },
        }
    }

    /// The last position that is believed, however long ago; `None` before the first one.
    pub(crate) fn steps(&self) -> Option<Steps> {
        self.filter.accepted()
    }

    /// The position, while there is one.
    pub(crate) fn valid_steps(&self) -> Option<Steps> {
        self.steps().filter(|_| self.faults < FAULTS_MAX)
    }

    /// The offset that brings the turn counter to its middle, and the sensor that waits for its
    /// first read under this offset. `None` while there is no position.
    pub(crate) fn centred(&self) -> Option<(TurnOffset, Self)> {
        let word = self.word.filter(|_| self.faults < FAULTS_MAX)?;
        let offset = ENCODER.centred(word);
        let filter = Filter::accepting(ENCODER.steps(word, offset));
        Some((offset, Self { filter, ..*self }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: filter::Params = filter::Params { width_steps: 100, jumps_max: 5 };
    const MIDDLE: [u8; SSI_READ_LEN] = [0b1110_0000, 0, 0, 0];
    const CUT: [u8; SSI_READ_LEN] = [0; SSI_READ_LEN];

    /// NM17x SENSOR-04, A-107: three failed reads in a row, not two.
    #[test]
    fn a_position_outlives_two_failed_reads() {
        for (reads, valid) in [
            (&[MIDDLE][..], true),
            (&[CUT], false),
            (&[MIDDLE, CUT, CUT], true),
            (&[MIDDLE, CUT, CUT, CUT], false),
            (&[MIDDLE, CUT, CUT, CUT, MIDDLE], true),
            (&[MIDDLE, CUT, CUT, MIDDLE, CUT, CUT], true),
        ] {
            let sensor = reads.iter().fold(Sensor::default(), |sensor, read| {
                sensor.step(read, TurnOffset::default(), &PARAMS)
            });
            assert_eq!(sensor.valid_steps().is_some(), valid, "{reads:?}");
        }
    }

    /// NM17x OD-2015-2: the position is in turn zero at once, not after the filter gave in.
    #[test]
    fn a_centred_sensor_needs_no_further_read() {
        let sensor = Sensor::default().step(&[0x80, 0, 0, 0x40], TurnOffset::default(), &PARAMS);
        assert_eq!(sensor.steps(), Some(Steps::new(-9_437_184)));
        let (offset, centred) = sensor.centred().unwrap();
        assert_eq!(centred.steps(), Some(Steps::ZERO));
        let next = centred.step(&[0x80, 0, 0, 0x40], offset, &PARAMS);
        assert_eq!(next.steps(), Some(Steps::ZERO));
        assert!(Sensor::default().centred().is_none());
    }
}
