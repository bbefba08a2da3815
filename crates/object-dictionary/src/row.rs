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

/// One entry of a dictionary: what it has alone, and what many entries have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    pub(crate) line: &'static Line,
    pub(crate) kind: &'static Kind,
}

/// What an entry has alone, in 8 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    pub(crate) index: u16,
    pub(crate) sub: u8,
    /// The place of its [`Kind`] in its dictionary; zero before it is in one.
    pub(crate) kind: u8,
    /// What it starts with. Texts start with zero.
    pub(crate) number: u32,
}

/// What many entries have in common, in 8 bytes on a controller of 32 bits, and more only where
/// there are [`Particulars`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    pub(crate) data_type: DataType,
    pub(crate) rights: Rights,
    pub(crate) particulars: Option<&'static Particulars>,
}

/// [`Access`], [`WriteState`], [`Storage`] and [`PdoMapping`], two bits each, then [`Owner`] and
/// whether the node-ID is added to the default, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rights(u16);

/// What few kinds have: limits narrower than their type, or a text at delivery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Particulars {
    pub(crate) text: Option<&'static str>,
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
        owner: Owner,
        adds_node_id: bool,
    ) -> Self {
        let modes = access as u16 | (write_state as u16) << 2 | (storage as u16) << 4;
        Self(modes | (pdo as u16) << 6 | (owner as u16) << 8 | (adds_node_id as u16) << 9)
    }
}

impl Kind {
    const PLAIN: Self =
        Self { data_type: DataType::Unsigned8, rights: Rights(0), particulars: None };

    /// Whether a dictionary keeps one of both only. Those with a text or further spans are rarely
    /// doubled, and are not compared.
    pub(crate) const fn is(&self, other: &Self) -> bool {
        if self.rights.0 != other.rights.0 {
            return false;
        }
        let (own, others) = (self.data_type, other.data_type);
        own.len() == others.len()
            && own.is_text() == others.is_text()
            && own.is_signed() == others.is_signed()
            && match (self.particulars, other.particulars) {
                (None, None) => true,
                (Some(own), Some(others)) => {
                    own.has_span_only()
                        && others.has_span_only()
                        && own.lowest == others.lowest
                        && own.highest == others.highest
                }
                (None, Some(_)) | (Some(_), None) => false,
            }
    }
}

impl Row {
    /// An entry of this kind; [`row!`](crate::row) makes both.
    #[must_use]
    pub const fn new(line: &'static Line, kind: &'static Kind) -> Self {
        Self { line, kind }
    }

    /// The row with this line of a dictionary that has these kinds. Every line names one of them: the
    /// plain kind stands in for none.
    pub(crate) fn of(line: &'static Line, kinds: &'static [Kind]) -> Self {
        Self { line, kind: kinds.get(usize::from(line.kind)).unwrap_or(&Kind::PLAIN) }
    }

    /// Index and sub-index.
    #[must_use]
    pub const fn id(self) -> ObjectId {
        ObjectId { index: self.line.index, sub: self.line.sub }
    }

    /// Type of the value.
    #[must_use]
    pub const fn data_type(self) -> DataType {
        self.kind.data_type
    }

    /// What a master may do with it.
    #[must_use]
    pub const fn access(self) -> Access {
        match self.kind.rights.0 & 3 {
            0 => Access::ReadOnly,
            1 => Access::WriteOnly,
            _ => Access::ReadWrite,
        }
    }

    /// When a master may write it.
    #[must_use]
    pub const fn write_state(self) -> WriteState {
        match self.kind.rights.0 >> 2 & 3 {
            0 => WriteState::Any,
            1 => WriteState::PreOperational,
            _ => WriteState::NotWithSdo,
        }
    }

    /// Where it survives.
    #[must_use]
    pub const fn storage(self) -> Storage {
        match self.kind.rights.0 >> 4 & 3 {
            0 => Storage::Volatile,
            1 => Storage::OnCommand,
            _ => Storage::AtOnce,
        }
    }

    /// Whether PDOs may carry it.
    #[must_use]
    pub const fn pdo(self) -> PdoMapping {
        match self.kind.rights.0 >> 6 & 3 {
            0 => PdoMapping::No,
            1 => PdoMapping::Transmit,
            2 => PdoMapping::Receive,
            _ => PdoMapping::Both,
        }
    }

    /// Who holds it.
    #[must_use]
    pub const fn owner(self) -> Owner {
        if self.kind.rights.0 >> 8 & 1 == Owner::Interface as u16 {
            Owner::Interface
        } else {
            Owner::Application
        }
    }

    /// Whether a master may write the number `raw` holds.
    #[must_use]
    pub fn permits(self, raw: u32) -> bool {
        self.check(raw).is_ok()
    }

    /// Whether a master may write the number `raw` holds.
    ///
    /// # Errors
    /// Says where the number lies instead.
    pub fn check(self, raw: u32) -> Result<(), OutOfLimits> {
        match self.kind.particulars {
            Some(particulars) => particulars.check(self.data_type(), raw),
            None => Ok(()),
        }
    }

    /// Whether all numbers of the type may be written.
    #[must_use]
    pub const fn is_unlimited(self) -> bool {
        self.kind.particulars.is_none()
    }

    /// The numbers that may be written.
    #[must_use]
    pub const fn limits(self) -> Limits {
        let data_type = self.data_type();
        match self.kind.particulars {
            Some(&Particulars { lowest, highest, also, .. }) => {
                Limits { min: data_type.ranked(lowest), max: data_type.ranked(highest), also }
            }
            None => {
                let (min, max) = data_type.span();
                Limits { min, max, also: &[] }
            }
        }
    }

    /// The value at delivery.
    #[must_use]
    pub const fn default(self) -> Default {
        match self.kind.particulars {
            Some(&Particulars { text: Some(text), .. }) => Default::Text(text),
            Some(_) | None if self.adds_node_id() => Default::NodeIdPlus(self.line.number),
            Some(_) | None => Default::Number(self.line.number),
        }
    }

    /// The text at delivery; an empty one where there is none.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self.kind.particulars {
            Some(&Particulars { text: Some(text), .. }) => text,
            Some(_) | None => "",
        }
    }

    /// The number an entry starts with on a device with this node-ID. Texts have none: zero.
    #[must_use]
    pub const fn initial(self, node_id: u8) -> u32 {
        let added = if self.adds_node_id() { node_id as u32 } else { 0 };
        self.line.number + added
    }

    const fn adds_node_id(self) -> bool {
        self.kind.rights.0 >> 9 != 0
    }
}

impl Particulars {
    /// Whether there is nothing but limits of one span.
    const fn has_span_only(&self) -> bool {
        self.text.is_none() && self.also.is_empty()
    }

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

/// The bytes of a line count for each of some hundred of them.
const _: () = assert!(size_of::<Line>() == 8);
#[cfg(target_pointer_width = "32")]
const _: () = assert!(size_of::<Kind>() == 8);
