/// Longest value, in bytes: the twelve characters of the display message and room to spare.
pub const VALUE_LEN_MAX: usize = 16;

/// One stored value: up to [`VALUE_LEN_MAX`] bytes whose meaning is the owner's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value {
    bytes: [u8; VALUE_LEN_MAX],
    len: u8,
}

/// A value and the key it is found under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// 0..=[`RECORD_KEY_MAX`](crate::RECORD_KEY_MAX); object index times 256 plus sub-index fits.
    pub key: u32,
    /// What is stored.
    pub value: Value,
}

impl Value {
    /// The value made of `bytes`; `None` if there are more than [`VALUE_LEN_MAX`].
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut value = Self { bytes: [0; VALUE_LEN_MAX], len: u8::try_from(bytes.len()).ok()? };
        value.bytes.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(value)
    }

    /// The bytes, 0..=[`VALUE_LEN_MAX`] of them.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or_default()
    }

    /// Number of bytes, 0..=[`VALUE_LEN_MAX`].
    #[must_use]
    pub(crate) fn len(&self) -> u8 {
        self.len
    }

    /// The number stored by `Value::from(u32)`; `None` for a value of another length.
    #[must_use]
    pub fn as_u32(&self) -> Option<u32> {
        self.as_bytes().try_into().ok().map(u32::from_le_bytes)
    }
}

impl From<u32> for Value {
    fn from(number: u32) -> Self {
        let [a, b, c, d] = number.to_le_bytes();
        Self { bytes: [a, b, c, d, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], len: 4 }
    }
}
