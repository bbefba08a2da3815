use core::marker::PhantomData;

use crate::row::{
    Access, DataType, Default, Kind, Line, ObjectId, Owner, Particulars, PdoMapping, Rights,
    Storage, WriteState,
};

/// A Rust type that an entry can hold.
pub trait Value {
    /// Its type on the bus.
    const DATA_TYPE: DataType;
}

/// A [`Value`] that is a number, kept in 32 bits (two's complement).
pub trait Number: Value + Copy {
    /// The number that the low bytes of `raw` are.
    fn from_raw(raw: u32) -> Self;

    /// The number in 32 bits.
    fn to_raw(self) -> u32;
}

macro_rules! numbers {
    ($($number:ty = $data_type:ident),+) => {$(
        impl Value for $number {
            const DATA_TYPE: DataType = DataType::$data_type;
        }

        impl Number for $number {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_possible_wrap,
                reason = "a number is the low bytes of its 32 bits"
            )]
            fn from_raw(raw: u32) -> Self {
                raw as Self
            }

            #[allow(
                clippy::cast_sign_loss,
                clippy::unnecessary_cast,
                trivial_numeric_casts,
                reason = "the 32 bits hold negative numbers in two's complement"
            )]
            fn to_raw(self) -> u32 {
                self as u32
            }
        }
    )+};
}

numbers! {
    u8 = Unsigned8, u16 = Unsigned16, u32 = Unsigned32, i8 = Integer8, i16 = Integer16, i32 = Integer32
}

/// A text of `LEN` bytes.
impl<const LEN: usize> Value for [u8; LEN] {
    #[expect(clippy::cast_possible_truncation, reason = "checked in the same line")]
    const DATA_TYPE: DataType = {
        assert!(LEN <= 255, "a text has at most 255 bytes");
        DataType::VisibleString(LEN as u8)
    };
}

/// What one step of a number means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A plain number.
    None,
    /// 1/100 mm.
    HundredthMm,
    /// ms.
    Millisecond,
    /// 0.1 s.
    TenthSecond,
    /// s.
    Second,
    /// 0.1 h.
    TenthHour,
    /// Unscaled steps of the sensor.
    SensorStep,
    /// 1/10,000,000 of 1/100 mm per sensor step.
    ScalingFactor,
    /// Bits.
    Bit,
}

/// Which files about a product list an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listing {
    /// Handbook and EDS file.
    Everywhere,
    /// The handbook alone.
    Handbook,
}

/// What only people read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text {
    /// Name as in the EDS file.
    pub name: &'static str,
    /// Unit of the number.
    pub unit: Unit,
    /// Where the entry is listed.
    pub listing: Listing,
}

/// An entry of a dictionary and the typed key to its value.
#[derive(Clone, Copy, Debug)]
pub struct Object<T> {
    id: ObjectId,
    access: Access,
    write_state: WriteState,
    storage: Storage,
    owner: Owner,
    pdo: PdoMapping,
    default: Default,
    particulars: Particulars,
    text: Text,
    value: PhantomData<fn() -> T>,
}

impl<T: Value> Object<T> {
    /// An entry that is read only, volatile, not mappable, held by the controller that its index
    /// says and zero.
    #[must_use]
    pub const fn new(index: u16, sub: u8, name: &'static str) -> Self {
        Self {
            id: ObjectId { index, sub },
            access: Access::ReadOnly,
            write_state: WriteState::Any,
            storage: Storage::Volatile,
            owner: if index < 0x2000 { Owner::Interface } else { Owner::Application },
            pdo: PdoMapping::No,
            default: Default::Number(0),
            particulars: Self::plain(),
            text: Text { name, unit: Unit::None, listing: Listing::Everywhere },
            value: PhantomData,
        }
    }

    /// All numbers of the type.
    const fn plain() -> Particulars {
        let (min, max) = T::DATA_TYPE.span();
        let (lowest, highest) = (Self::rank(min), Self::rank(max));
        Particulars { text: None, lowest, highest, also: &[] }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the callers check against the span of the type"
    )]
    const fn rank(number: i64) -> u32 {
        T::DATA_TYPE.rank(number as u32)
    }

    /// Masters may read and write it.
    #[must_use]
    pub const fn read_write(mut self) -> Self {
        self.access = Access::ReadWrite;
        self
    }

    /// Masters may only write it.
    #[must_use]
    pub const fn write_only(mut self) -> Self {
        self.access = Access::WriteOnly;
        self
    }

    /// A master may write it in Pre-operational alone.
    #[must_use]
    pub const fn written_in_pre_operational(mut self) -> Self {
        self.write_state = WriteState::PreOperational;
        self
    }

    /// A write with SDO is refused in every state as an access that is not supported.
    #[must_use]
    pub const fn not_written_with_sdo(mut self) -> Self {
        self.write_state = WriteState::NotWithSdo;
        self
    }

    /// Saved when a master asks for it (0x1010).
    #[must_use]
    pub const fn stored_on_command(mut self) -> Self {
        self.storage = Storage::OnCommand;
        self
    }

    /// Saved with every change.
    #[must_use]
    pub const fn stored_at_once(mut self) -> Self {
        self.storage = Storage::AtOnce;
        self
    }

    /// Held by the CAN interface controller although its index lies outside the communication
    /// area.
    #[must_use]
    pub const fn held_by_interface(mut self) -> Self {
        self.owner = Owner::Interface;
        self
    }

    /// PDOs may carry it.
    #[must_use]
    pub const fn mappable(mut self, pdo: PdoMapping) -> Self {
        self.pdo = pdo;
        self
    }

    /// Only `min` to `max` may be written, ends included.
    #[must_use]
    pub const fn within(mut self, min: i64, max: i64) -> Self {
        let (lowest, highest) = T::DATA_TYPE.span();
        assert!(lowest <= min && min <= max && max <= highest, "limits outside the type");
        self.particulars.lowest = Self::rank(min);
        self.particulars.highest = Self::rank(max);
        self
    }

    /// Besides the span of [`Self::within`], these spans may be written.
    #[must_use]
    pub const fn or_within(mut self, also: &'static [(i64, i64)]) -> Self {
        self.particulars.also = also;
        self
    }

    /// The value at delivery.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked against the span of the type in the line above"
    )]
    pub const fn default(mut self, value: i64) -> Self {
        let (lowest, highest) = T::DATA_TYPE.span();
        assert!(lowest <= value && value <= highest, "default outside the type");
        self.default = Default::Number(value as u32);
        self
    }

    /// The value at delivery follows the node-ID: `base` plus node-ID.
    #[must_use]
    pub const fn default_node_id_plus(mut self, base: u32) -> Self {
        self.default = Default::NodeIdPlus(base);
        self
    }

    /// The text at delivery.
    #[must_use]
    pub const fn default_text(mut self, text: &'static str) -> Self {
        assert!(text.len() == T::DATA_TYPE.len(), "the text does not have the object's length");
        self.default = Default::Text(text);
        self
    }

    /// What one step of the number means.
    #[must_use]
    pub const fn unit(mut self, unit: Unit) -> Self {
        self.text.unit = unit;
        self
    }

    /// The EDS file does not have it.
    #[must_use]
    pub const fn not_in_eds(mut self) -> Self {
        self.text.listing = Listing::Handbook;
        self
    }

    /// Index and sub-index.
    #[must_use]
    pub const fn id(&self) -> ObjectId {
        self.id
    }

    /// What the row of the table has alone.
    #[must_use]
    pub const fn line(&self) -> Line {
        let number = match self.default {
            Default::Number(number) | Default::NodeIdPlus(number) => number,
            Default::Text(_) => 0,
        };
        Line { index: self.id.index, sub: self.id.sub, kind: 0, number }
    }

    /// What the row has in common with others; [`row!`](crate::row) gives it what
    /// [`Self::particulars`] has.
    #[must_use]
    pub const fn kind(&self, particulars: &'static Particulars) -> Kind {
        let plain = Self::plain();
        let is_particular = particulars.lowest != plain.lowest
            || particulars.highest != plain.highest
            || !particulars.also.is_empty()
            || particulars.text.is_some();
        let adds_node_id = matches!(self.default, Default::NodeIdPlus(_));
        Kind {
            data_type: T::DATA_TYPE,
            rights: Rights::new(
                self.access,
                self.write_state,
                self.storage,
                self.pdo,
                self.owner,
                adds_node_id,
            ),
            particulars: if is_particular { Some(particulars) } else { None },
        }
    }

    /// What few kinds have.
    #[must_use]
    pub const fn particulars(&self) -> Particulars {
        let text = match self.default {
            Default::Text(text) => Some(text),
            Default::Number(_) | Default::NodeIdPlus(_) => None,
        };
        Particulars { text, ..self.particulars }
    }

    /// What only people read.
    #[must_use]
    pub const fn text(&self) -> Text {
        self.text
    }
}

impl Object<u8> {
    /// Sub-index 0 of a record or array: the highest sub-index.
    #[must_use]
    pub const fn highest_sub_index(index: u16, name: &'static str, highest: u8) -> Self {
        Self::new(index, 0, name).default(highest as i64)
    }
}
