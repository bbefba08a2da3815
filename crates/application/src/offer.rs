//! A node-ID on offer to the device that is touched (manual 3.1.3; NM17x ADDR-08, ADDR-09).

use units::Steps;

/// How far the shaft has to be turned: a quarter of a turn (NM17x A-49).
const TOUCHED_BEYOND: u64 = 2_304 / 4;

/// What is on offer, and whether the user took it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Offer {
    node_id: u8,
    standing: Standing,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    /// It waits for a touch: the shaft was here when it came.
    Open { number: u8, from: Option<Steps> },
    /// It was touched.
    Touched { number: u8 },
    /// The other controller knows of the touch.
    Closed,
}

impl Offer {
    /// What the other controller says: see `OFFER`. `None` for the end of all offers.
    pub(crate) fn from_raw(raw: u32) -> Option<Self> {
        let [node_id, number, ..] = raw.to_le_bytes();
        let standing = match number {
            0 => Standing::Closed,
            number => Standing::Open { number, from: None },
        };
        (node_id != 0).then_some(Self { node_id, standing })
    }

    /// Looks at the shaft, and at a key that has just been pressed.
    pub(crate) fn step(self, steps: Option<Steps>, key: Key) -> Self {
        let Standing::Open { number, from } = self.standing else { return self };
        let from = from.or(steps);
        let turned = from
            .zip(steps)
            .is_some_and(|(from, steps)| from.count().abs_diff(steps.count()) >= TOUCHED_BEYOND);
        let standing = if turned || key == Key::Pressed {
            Standing::Touched { number }
        } else {
            Standing::Open { number, from }
        };
        Self { standing, ..self }
    }

    /// The node-ID to show.
    pub(crate) fn node_id(&self) -> u8 {
        self.node_id
    }

    /// The number of the offer that was touched, until the other controller knows.
    pub(crate) fn touched(&self) -> Option<u8> {
        match self.standing {
            Standing::Touched { number } => Some(number),
            Standing::Open { .. } | Standing::Closed => None,
        }
    }
}

/// What the keys did in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// None was pressed that had not been before.
    Untouched,
    /// One was.
    Pressed,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x ADDR-09, A-49: a quarter of a turn either way, or a key.
    #[test]
    fn an_offer_is_taken_by_a_touch() {
        let touched = |places: &[i64], key| {
            let offer = Offer::from_raw(0x0725).unwrap();
            let steps = places.iter().map(|place| Some(Steps::new(*place)));
            steps.fold(offer, |offer, steps| offer.step(steps, key)).touched()
        };
        for (places, expected) in [
            (&[100][..], None),
            (&[100, 675], None),
            (&[100, 676], Some(7)),
            (&[100, -475], None),
            (&[100, -476], Some(7)),
            (&[100, 676, 100], Some(7)),
        ] {
            assert_eq!(touched(places, Key::Untouched), expected, "{places:?}");
        }
        assert_eq!(touched(&[100], Key::Pressed), Some(7));
        let closed = Offer::from_raw(0x0025).unwrap();
        assert_eq!((closed.node_id(), closed.step(None, Key::Pressed).touched()), (0x25, None));
        assert_eq!(Offer::from_raw(0), None);
    }
}
