/// An identifier: it names the content of a frame and is its priority.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Id {
    /// 11 bits (CAN 2.0A).
    Standard(u16),
    /// 29 bits (CAN 2.0B).
    Extended(u32),
}

impl Id {
    /// The highest standard identifier.
    pub const STANDARD_MAX: u16 = 0x7FF;
    /// The highest extended identifier.
    pub const EXTENDED_MAX: u32 = 0x1FFF_FFFF;

    /// The identifier as a number.
    #[must_use]
    pub const fn value(self) -> u32 {
        match self {
            Self::Standard(id) => id as u32,
            Self::Extended(id) => id,
        }
    }

    /// Whether it has 29 bits.
    #[must_use]
    pub const fn is_extended(self) -> bool {
        matches!(self, Self::Extended(_))
    }
}

/// Why bytes are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The identifier has more bits than its format.
    Identifier,
    /// More than 8 bytes.
    Length,
}

impl std::fmt::Display for FrameError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Identifier => "the identifier is out of range",
            Self::Length => "a frame holds at most 8 bytes",
        })
    }
}

impl std::error::Error for FrameError {}

/// A classic CAN frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Frame {
    id: Id,
    remote: bool,
    dlc: u8,
    data: [u8; 8],
}

/// The most bytes a frame carries.
pub(crate) const DLC_MAX: u8 = 8;

impl Frame {
    /// A data frame.
    ///
    /// # Errors
    /// When `id` is out of its format's range or `data` has more than 8 bytes.
    pub fn new(id: Id, data: &[u8]) -> Result<Self, FrameError> {
        let mut frame = Self::remote(id, u8::try_from(data.len()).unwrap_or(u8::MAX))?;
        frame.remote = false;
        for (to, from) in frame.data.iter_mut().zip(data) {
            *to = *from;
        }
        Ok(frame)
    }

    /// A remote frame asking for `dlc` bytes.
    ///
    /// # Errors
    /// When `id` is out of its format's range or `dlc` is above 8.
    pub const fn remote(id: Id, dlc: u8) -> Result<Self, FrameError> {
        let in_range = match id {
            Id::Standard(id) => id <= Id::STANDARD_MAX,
            Id::Extended(id) => id <= Id::EXTENDED_MAX,
        };
        if !in_range {
            return Err(FrameError::Identifier);
        }
        if dlc > DLC_MAX {
            return Err(FrameError::Length);
        }
        Ok(Self { id, remote: true, dlc, data: [0; 8] })
    }

    /// Its identifier.
    #[must_use]
    pub const fn id(&self) -> Id {
        self.id
    }

    /// Whether it asks for data instead of carrying them.
    #[must_use]
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code, 0 to 8.
    #[must_use]
    pub const fn dlc(&self) -> u8 {
        self.dlc
    }

    /// The bytes carried; none in a remote frame.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        let len = if self.remote { 0 } else { usize::from(self.dlc) };
        self.data.get(..len).unwrap_or_default()
    }

    /// The arbitration field, first bit uppermost: of two frames starting together the one with the
    /// lower value goes on (a dominant bit is a 0).
    ///
    /// Base identifier, RTR or SRR, IDE, extension, RTR: so a standard frame beats an extended one
    /// of the same base, and a data frame the remote frame of the same identifier.
    #[must_use]
    pub const fn arbitration(&self) -> u32 {
        let remote = self.remote as u32;
        match self.id {
            Id::Standard(id) => (id as u32) << 21 | remote << 20,
            Id::Extended(id) => (id >> 18) << 21 | 0b11 << 19 | (id & 0x3_FFFF) << 1 | remote,
        }
    }
}
