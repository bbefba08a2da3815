use crate::frame::CanId;

/// A kind of frame that a node listens to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accepted {
    /// Its identifier.
    pub id: CanId,
    /// Whether it is the remote frame that counts.
    pub remote: bool,
}

/// Turns most frames for others away at once: one bit for each value of an identifier's low seven
/// bits, which are the node-ID in the pre-defined connection set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Screen([u32; 4]);

impl Screen {
    /// Nothing passes.
    pub(crate) const CLOSED: Self = Self([0; 4]);

    /// Lets frames with this identifier pass.
    pub(crate) fn open(&mut self, id: CanId) {
        let (word, bit) = place(id);
        if let Some(word) = self.0.get_mut(word) {
            *word |= 1 << bit;
        }
    }

    /// Whether the node may listen to frames with this identifier.
    #[inline]
    pub(crate) fn passes(&self, id: CanId) -> bool {
        let (word, bit) = place(id);
        self.0.get(word).is_some_and(|word| word >> bit & 1 != 0)
    }
}

const fn place(id: CanId) -> (usize, u16) {
    let low = id.get() & 0x7F;
    ((low >> 5) as usize, low & 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shares_the_low_bits_passes_and_nothing_else() {
        let id = |id| CanId::new(id).unwrap();
        let mut screen = Screen::CLOSED;
        screen.open(id(0x67F));
        screen.open(id(0x080));
        for (frame, passes) in [
            (0x67F, true),
            (0x37F, true),
            (0x080, true),
            (0x000, true),
            (0x67E, false),
            (0x081, false),
            (0x020, false),
            (0x7FF, true),
        ] {
            assert_eq!(screen.passes(id(frame)), passes, "{frame:03X}");
        }
        assert!(!Screen::CLOSED.passes(id(0)));
    }
}
