/// Index and sub-index of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectId {
    /// Index, 0x0000 to 0xFFFF.
    pub index: u16,
    /// Sub-index, 0 to 255.
    pub sub: u8,
}

/// Data types of CiA 301, section 7.4.7, as far as the products have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataType {
    /// UNSIGNED8.
    Unsigned8,
    /// UNSIGNED16.
    Unsigned16,
    /// UNSIGNED32.
    Unsigned32,
    /// INTEGER8.
    Integer8,
    /// INTEGER16.
    Integer16,
    /// INTEGER32.
    Integer32,
    /// VISIBLE_STRING of a fixed length, in bytes.
    VisibleString(u8),
}

/// What a master may do with an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `ro`.
    ReadOnly,
    /// `wo`.
    WriteOnly,
    /// `rw`.
    ReadWrite,
}

/// The NMT states in which a master may write an entry that [`Access`] lets it write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteState {
    /// In Pre-operational and in Operational.
    Any,
    /// In Pre-operational alone.
    PreOperational,
    /// With SDO in none, which is refused as an access that is not supported: the value comes with
    /// a receive PDO, or not from masters at all.
    NotWithSdo,
}

/// Where a value survives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Lost with the supply.
    Volatile,
    /// Saved on command (0x1010).
    OnCommand,
    /// Saved with every change.
    AtOnce,
}

/// The controller that holds the value; the other one keeps a copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// The CAN interface controller.
    Interface,
    /// The application controller.
    Application,
}

/// Whether a PDO may carry the entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PdoMapping {
    /// In no PDO.
    No,
    /// In transmit PDOs.
    Transmit,
    /// In receive PDOs.
    Receive,
    /// In both.
    Both,
}

/// The value of an entry at delivery and after a restore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Default {
    /// A fixed number, as the 32 bits the value is kept in.
    Number(u32),
    /// A number plus the node-ID (`$NODEID+…` in an EDS file).
    NodeIdPlus(u32),
    /// A fixed text.
    Text(&'static str),
}

/// The numbers a master may write: one span, and further single spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Smallest value of the main span.
    pub min: i64,
    /// Largest value of the main span.
    pub max: i64,
    /// Further permitted spans, ends included.
    pub also: &'static [(i64, i64)],
}

/// Why a number may not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutOfLimits {
    /// It lies above the only span.
    Above,
    /// It lies below the only span.
    Below,
    /// It lies in none of several spans.
    Beside,
}

/// One entry of a dictionary, as an image needs it: 12 bytes on a controller of 32 bits, and more
/// only where there are [`Particulars`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    pub(crate) rights: Rights,
    pub(crate) start: Start,
}

/// [`Access`], [`WriteState`], [`Storage`] and [`PdoMapping`], two bits each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rights(u8);

/// How an entry starts. Type and owner lie in the bytes that the number leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Start {
    /// With this number.
    Number(DataType, Owner, u32),
    /// With this number plus the node-ID.
    NodeIdPlus(DataType, Owner, u32),
    /// As these say.
    Particular(DataType, Owner, &'static Particulars),
}

/// What few rows have: limits narrower than their type, or a text at delivery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Particulars {
    pub(crate) default: Default,
    /// Ends of the main span, in the order of the type (see [`DataType::rank`]).
    pub(crate) lowest: u32,
    pub(crate) highest: u32,
    pub(crate) also: &'static [(i64, i64)],
}

impl ObjectId {
    /// Index and sub-index as one number that orders like the dictionary.
    #[must_use]
    pub const fn key(self) -> u32 {
        (self.index as u32) << 8 | self.sub as u32
    }
}

impl DataType {
    /// Length of a value in bytes.
    #[must_use]
    pub const fn len(self) -> usize {
        match self {
            Self::Unsigned8 | Self::Integer8 => 1,
            Self::Unsigned16 | Self::Integer16 => 2,
            Self::Unsigned32 | Self::Integer32 => 4,
            Self::VisibleString(len) => len as usize,
        }
    }

    /// Whether values of the type are texts; all others are numbers.
    #[must_use]
    pub const fn is_text(self) -> bool {
        matches!(self, Self::VisibleString(_))
    }

    /// Whether values of the type have no bytes.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The number that the low bytes of `raw` are in this type, in 32 bits (two's complement).
    /// Texts have none: zero.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss,
        reason = "the casts are how a type reads its own low bytes"
    )]
    pub const fn widen(self, raw: u32) -> u32 {
        match self {
            Self::Unsigned8 => raw as u8 as u32,
            Self::Unsigned16 => raw as u16 as u32,
            Self::Unsigned32 | Self::Integer32 => raw,
            Self::Integer8 => raw as u8 as i8 as u32,
            Self::Integer16 => raw as u16 as i16 as u32,
            Self::VisibleString(_) => 0,
        }
    }

    /// The number that the low bytes of `raw` are in this type. Texts have none: zero.
    #[must_use]
    pub const fn number(self, raw: u32) -> i64 {
        let widened = self.widen(raw);
        if self.is_signed() { widened.cast_signed() as i64 } else { widened as i64 }
    }

    /// A place among the numbers of the type: the greater the number, the greater its rank.
    pub(crate) const fn rank(self, widened: u32) -> u32 {
        if self.is_signed() { widened ^ 1 << 31 } else { widened }
    }

    /// Whether values of the type are numbers that may be negative.
    #[must_use]
    pub const fn is_signed(self) -> bool {
        matches!(self, Self::Integer8 | Self::Integer16 | Self::Integer32)
    }

    /// The number with this rank.
    const fn ranked(self, rank: u32) -> i64 {
        self.number(self.rank(rank))
    }

    /// The smallest and the largest number of the type.
    #[must_use]
    pub const fn span(self) -> (i64, i64) {
        match self {
            Self::Unsigned8 => (0, u8::MAX as i64),
            Self::Unsigned16 => (0, u16::MAX as i64),
            Self::Unsigned32 => (0, u32::MAX as i64),
            Self::Integer8 => (i8::MIN as i64, i8::MAX as i64),
            Self::Integer16 => (i16::MIN as i64, i16::MAX as i64),
            Self::Integer32 => (i32::MIN as i64, i32::MAX as i64),
            Self::VisibleString(_) => (0, 0),
        }
    }
}

impl Rights {
    pub(crate) const fn new(
        access: Access,
        write_state: WriteState,
        storage: Storage,
        pdo: PdoMapping,
    ) -> Self {
        Self(access as u8 | (write_state as u8) << 2 | (storage as u8) << 4 | (pdo as u8) << 6)
    }
}

impl Row {
    /// Index and sub-index.
    #[must_use]
    pub const fn id(&self) -> ObjectId {
        ObjectId { index: self.index, sub: self.sub }
    }

    /// Type of the value.
    #[must_use]
    pub const fn data_type(&self) -> DataType {
        match self.start {
            Start::Number(data_type, ..)
            | Start::NodeIdPlus(data_type, ..)
            | Start::Particular(data_type, ..) => data_type,
        }
    }

    /// What a master may do with it.
    #[must_use]
    pub const fn access(&self) -> Access {
        match self.rights.0 & 3 {
            0 => Access::ReadOnly,
            1 => Access::WriteOnly,
            _ => Access::ReadWrite,
        }
    }

    /// When a master may write it.
    #[must_use]
    pub const fn write_state(&self) -> WriteState {
        match self.rights.0 >> 2 & 3 {
            0 => WriteState::Any,
            1 => WriteState::PreOperational,
            _ => WriteState::NotWithSdo,
        }
    }

    /// Where it survives.
    #[must_use]
    pub const fn storage(&self) -> Storage {
        match self.rights.0 >> 4 & 3 {
            0 => Storage::Volatile,
            1 => Storage::OnCommand,
            _ => Storage::AtOnce,
        }
    }

    /// Whether PDOs may carry it.
    #[must_use]
    pub const fn pdo(&self) -> PdoMapping {
        match self.rights.0 >> 6 {
            0 => PdoMapping::No,
            1 => PdoMapping::Transmit,
            2 => PdoMapping::Receive,
            _ => PdoMapping::Both,
        }
    }

    /// Who holds it.
    #[must_use]
    pub const fn owner(&self) -> Owner {
        match self.start {
            Start::Number(_, owner, _)
            | Start::NodeIdPlus(_, owner, _)
            | Start::Particular(_, owner, _) => owner,
        }
    }

    /// Whether a master may write the number `raw` holds.
    #[must_use]
    pub fn permits(&self, raw: u32) -> bool {
        self.check(raw).is_ok()
    }

    /// Whether a master may write the number `raw` holds.
    ///
    /// # Errors
    /// Says where the number lies instead.
    pub fn check(&self, raw: u32) -> Result<(), OutOfLimits> {
        match self.start {
            Start::Particular(data_type, _, particulars) => particulars.check(data_type, raw),
            Start::Number(..) | Start::NodeIdPlus(..) => Ok(()),
        }
    }

    /// Whether all numbers of the type may be written.
    #[must_use]
    pub const fn is_unlimited(&self) -> bool {
        !matches!(self.start, Start::Particular(..))
    }

    /// The numbers that may be written.
    #[must_use]
    pub const fn limits(&self) -> Limits {
        match self.start {
            Start::Particular(data_type, _, &Particulars { lowest, highest, also, .. }) => {
                Limits { min: data_type.ranked(lowest), max: data_type.ranked(highest), also }
            }
            Start::Number(data_type, ..) | Start::NodeIdPlus(data_type, ..) => {
                let (min, max) = data_type.span();
                Limits { min, max, also: &[] }
            }
        }
    }

    /// The value at delivery.
    #[must_use]
    pub const fn default(&self) -> Default {
        match self.start {
            Start::Number(_, _, number) => Default::Number(number),
            Start::NodeIdPlus(_, _, base) => Default::NodeIdPlus(base),
            Start::Particular(_, _, particulars) => particulars.default,
        }
    }

    /// The text at delivery; an empty one where there is none.
    #[must_use]
    pub const fn text(&self) -> &'static str {
        match self.start {
            Start::Particular(_, _, &Particulars { default: Default::Text(text), .. }) => text,
            Start::Particular(..) | Start::Number(..) | Start::NodeIdPlus(..) => "",
        }
    }

    /// The number an entry starts with on a device with this node-ID. Texts have none: zero.
    #[must_use]
    pub const fn initial(&self, node_id: u8) -> u32 {
        match self.default() {
            Default::Number(number) => number,
            Default::NodeIdPlus(base) => base + node_id as u32,
            Default::Text(_) => 0,
        }
    }
}

impl Particulars {
    fn check(&self, data_type: DataType, raw: u32) -> Result<(), OutOfLimits> {
        let rank = data_type.rank(data_type.widen(raw));
        if (self.lowest..=self.highest).contains(&rank) {
            return Ok(());
        }
        if self.also.is_empty() {
            return Err(if rank > self.highest { OutOfLimits::Above } else { OutOfLimits::Below });
        }
        let number = data_type.number(raw);
        let fits = self.also.iter().any(|&(first, last)| (first..=last).contains(&number));
        if fits { Ok(()) } else { Err(OutOfLimits::Beside) }
    }
}

/// The bytes of a row count for each of some hundred of them.
#[cfg(target_pointer_width = "32")]
const _: () = assert!(size_of::<Row>() == 12);
