use crate::dictionary::{Dictionary, Slot};
use crate::object::{Number, Object};

/// The numbers of a dictionary, one of 32 bits for each row. Texts keep no place of their own: they
/// are the default of their row or live with whoever owns them.
#[derive(Debug)]
pub struct Values<const LEN: usize> {
    dictionary: &'static Dictionary,
    numbers: [u32; LEN],
}

impl<const LEN: usize> Values<LEN> {
    /// All values at their defaults for this node-ID. `LEN` is the length of `dictionary`; rows
    /// beyond it would read zero.
    #[must_use]
    pub fn new(dictionary: &'static Dictionary, node_id: u8) -> Self {
        let mut rows = dictionary.rows();
        let numbers = core::array::from_fn(|_| rows.next().map_or(0, |row| row.initial(node_id)));
        Self { dictionary, numbers }
    }

    /// The rows these are the values of.
    #[must_use]
    pub const fn dictionary(&self) -> &'static Dictionary {
        self.dictionary
    }

    /// The value of `object`; its type's zero when the product does not have it.
    #[must_use]
    pub fn get<T: Number>(&self, object: &Object<T>) -> T {
        T::from_raw(self.dictionary.find(object.id()).map_or(0, |slot| self.raw(slot)))
    }

    /// Takes `value` over without a check. Nothing when the product does not have `object`.
    pub fn set<T: Number>(&mut self, object: &Object<T>, value: T) {
        if let Ok(slot) = self.dictionary.find(object.id()) {
            self.set_raw(slot, value.to_raw());
        }
    }

    /// The 32 bits at `slot`.
    #[must_use]
    pub fn raw(&self, slot: Slot) -> u32 {
        self.numbers.get(usize::from(slot.position())).copied().unwrap_or(0)
    }

    /// Takes 32 bits over without a check.
    pub fn set_raw(&mut self, slot: Slot, raw: u32) {
        if let Some(number) = self.numbers.get_mut(usize::from(slot.position())) {
            *number = raw;
        }
    }
}
