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
    /// In none with SDO: the value comes with a receive PDO.
    PdoOnly,
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

/// One entry of a dictionary, as an image needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Index and sub-index.
    pub id: ObjectId,
    /// Type of the value.
    pub data_type: DataType,
    /// What a master may do with it.
    pub access: Access,
    /// When a master may write it.
    pub write_state: WriteState,
    /// Where it survives.
    pub storage: Storage,
    /// Who holds it.
    pub owner: Owner,
    /// Whether PDOs may carry it.
    pub pdo: PdoMapping,
    /// Value at delivery.
    pub default: Default,
    /// What may be written.
    pub limits: Limits,
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

    /// Whether values of the type have no bytes.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The number that the low bytes of `raw` are in this type. Texts have none: zero.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "the casts are how a type reads its own low bytes"
    )]
    pub const fn number(self, raw: u32) -> i64 {
        match self {
            Self::Unsigned8 => raw as u8 as i64,
            Self::Unsigned16 => raw as u16 as i64,
            Self::Unsigned32 => raw as i64,
            Self::Integer8 => raw as u8 as i8 as i64,
            Self::Integer16 => raw as u16 as i16 as i64,
            Self::Integer32 => raw as i32 as i64,
            Self::VisibleString(_) => 0,
        }
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

impl Limits {
    /// Whether `value` lies in one of the spans.
    #[must_use]
    pub fn permit(&self, value: i64) -> bool {
        (self.min..=self.max).contains(&value)
            || self.also.iter().any(|&(first, last)| (first..=last).contains(&value))
    }
}

impl Row {
    /// Whether a master may write the number `raw` holds.
    #[must_use]
    pub fn permits(&self, raw: u32) -> bool {
        self.limits.permit(self.data_type.number(raw))
    }

    /// The number an entry starts with on a device with this node-ID. Texts have none: zero.
    #[must_use]
    pub const fn initial(&self, node_id: u8) -> u32 {
        match self.default {
            Default::Number(value) => value,
            Default::NodeIdPlus(base) => base + node_id as u32,
            Default::Text(_) => 0,
        }
    }
}
