//! Disturbed reads of the sensor (NM17x FILTER-01 to FILTER-04, A-108).
//!
//! A shaft cannot jump. A read that lies further from the last accepted one than a shaft turns
//! between two reads is a disturbance and dropped, until so many of them came in a row that the
//! shaft must be believed to be there.

use units::Steps;

/// The filter between two reads. Starts without an accepted position: the first one is believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    accepted: Option<Steps>,
    jumps: u8,
}

/// What counts as a jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Widest change that is no jump, in sensor steps, 0 to 2303 (0x2005:01).
    pub width_steps: u32,
    /// Jumps in a row that are dropped, 0 to 99; 0 drops none (0x2005:02).
    pub jumps_max: u8,
}

impl Filter {
    /// A filter that has accepted `position`.
    #[must_use]
    pub const fn accepting(position: Steps) -> Self {
        Self { accepted: Some(position), jumps: 0 }
    }

    /// Takes a read in and gives the position that is valid after it.
    #[must_use]
    pub fn step(self, read: Steps, params: &Params) -> (Self, Steps) {
        match self.accepted {
            Some(valid) if is_jump(valid, read, params) && self.jumps < params.jumps_max => {
                (Self { accepted: Some(valid), jumps: self.jumps + 1 }, valid)
            }
            Some(_) | None => (Self::accepting(read), read),
        }
    }

    /// The last accepted position; `None` before the first read.
    #[must_use]
    pub const fn accepted(&self) -> Option<Steps> {
        self.accepted
    }
}

fn is_jump(valid: Steps, read: Steps, params: &Params) -> bool {
    (read - valid).count().unsigned_abs() > u64::from(params.width_steps)
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    fn valid(width_steps: u32, jumps_max: u8, reads: &[i64]) -> Vec<i64> {
        let params = Params { width_steps, jumps_max };
        let mut filter = Filter::default();
        let mut taken = Vec::new();
        for &read in reads {
            let (next, valid) = filter.step(Steps::new(read), &params);
            filter = next;
            taken.push(valid.count());
        }
        taken
    }

    /// NM17x FILTER-01, FILTER-02, FILTER-03 with the corner cases of A-108.
    #[test]
    fn jumps_are_dropped_until_there_are_too_many() {
        for (width, jumps, reads, expected) in [
            // The sixth jump is accepted at a count of 5, and counting starts again.
            (
                100,
                5,
                &[0, 500, 500, 500, 500, 500, 500, 0, 500][..],
                &[0, 0, 0, 0, 0, 0, 500, 500, 500][..],
            ),
            // A value within the width in between clears the count.
            (100, 2, &[0, 500, 500, 7, 500, 500, 500], &[0, 0, 0, 7, 7, 7, 500]),
            // Exactly the width is no jump, one more is.
            (100, 1, &[0, 100, 201, 0, 101, 101], &[0, 100, 100, 0, 0, 101]),
            // The jump is measured from the last accepted value, in either direction.
            (100, 2, &[0, -101, 101, 0], &[0, 0, 0, 0]),
            (100, 2, &[0, -101, 101, -101], &[0, 0, 0, -101]),
            // A count of 0 is no filter; a width of 0 calls every change a jump.
            (100, 0, &[0, 5_000, -5_000], &[0, 5_000, -5_000]),
            (0, 1, &[0, 1, 1, 0], &[0, 0, 1, 1]),
            // The first read is believed.
            (100, 5, &[9_437_183, 9_437_100], &[9_437_183, 9_437_100]),
        ] {
            assert_eq!(valid(width, jumps, reads), expected, "width {width}, {jumps} jumps");
        }
    }

    proptest! {
        /// NM17x FILTER-02: whatever is read, the shown value is at most the dropped reads old.
        #[test]
        fn a_value_is_never_older_than_the_count(
            reads in proptest::collection::vec(-9_437_184_i64..9_437_184, 1..200),
            width in 0_u32..2_304,
            jumps in 0_u8..100,
        ) {
            for (n, shown) in valid(width, jumps, &reads).iter().enumerate() {
                let recent = &reads[n.saturating_sub(usize::from(jumps))..=n];
                prop_assert!(recent.contains(shown));
            }
        }

        #[test]
        fn the_ends_of_the_number_range_do_no_harm(a: i64, b: i64, width: u32) {
            let params = Params { width_steps: width, jumps_max: 1 };
            let (filter, _) = Filter::default().step(Steps::new(a), &params);
            let (filter, _) = filter.step(Steps::new(b), &params);
            prop_assert!(filter.accepted() == Some(Steps::new(a)) || filter.accepted() == Some(Steps::new(b)));
        }
    }
}
