//! What the families of products do differently.

use canopen::{Frame, Node, WriteError, Written};
use object_dictionary::{Number, Object, ObjectId, Values};
use profiles::OBJECTS_MAX;
use units::Instant;

use crate::{ap04, encoder};

/// A family of products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    Ap04,
    Encoder,
}

/// The values of a node as its product sees them.
pub(crate) struct View<'a> {
    pub(crate) now: Instant,
    pub(crate) node: &'a mut Node<OBJECTS_MAX>,
}

impl View<'_> {
    pub(crate) fn get<T: Number>(&self, object: &Object<T>) -> T {
        self.node.values().get(object)
    }

    pub(crate) fn set<T: Number>(&mut self, object: &Object<T>, value: T) {
        if let Ok(slot) = self.node.values().dictionary().find(object.id()) {
            self.node.set_value(self.now, slot, value.to_raw());
        }
    }
}

/// What a write depends on, as it is before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Present {
    /// Whether 0x6001 may be written.
    pub(crate) units_are_open: bool,
    /// What 0x6003 has to be below; `None` without such an end.
    pub(crate) preset_below: Option<u32>,
    /// Units per turn and in all turns.
    pub(crate) scale: (u32, u32),
}

impl Present {
    /// Whether the product takes a number that its row permits.
    pub(crate) fn check(&self, object: ObjectId, raw: u32) -> Result<Written, WriteError> {
        const UNITS_PER_TURN: ObjectId = profiles::ap04::UNITS_PER_TURN.id();
        const PRESET: ObjectId = profiles::ap04::PRESET.id();
        const ZERO_POSITION: ObjectId = profiles::ap04::ZERO_POSITION.id();
        match object {
            UNITS_PER_TURN if !self.units_are_open => Err(WriteError::DeviceState),
            PRESET if self.preset_below.is_some_and(|below| raw >= below) => {
                Err(WriteError::AboveMaximum)
            }
            ZERO_POSITION if raw == 0 => Ok(Written::Ignored),
            _ => Ok(Written::Taken),
        }
    }
}

impl Family {
    /// The object with the node-ID.
    pub(crate) const fn node_id(self) -> Object<u8> {
        match self {
            Self::Ap04 => profiles::ap04::NODE_ID,
            Self::Encoder => profiles::encoder::NODE_ID,
        }
    }

    /// The bit rate that follows from the values at the start, in bit/s.
    pub(crate) fn bit_rate(self, values: &Values<OBJECTS_MAX>) -> u32 {
        match self {
            Self::Ap04 => ap04::BIT_RATE,
            Self::Encoder => encoder::bit_rate(values),
        }
    }

    /// Whether the CAN controller comes back from bus-off by itself.
    pub(crate) fn recovers_from_bus_off(self, values: &Values<OBJECTS_MAX>) -> bool {
        match self {
            Self::Ap04 => true,
            Self::Encoder => encoder::recovers_from_bus_off(values),
        }
    }

    /// Whether the shaft is read again for this frame.
    pub(crate) fn reads_for(self, values: &Values<OBJECTS_MAX>, frame: &Frame) -> bool {
        match self {
            Self::Ap04 => false,
            Self::Encoder => encoder::reads_for(values, frame),
        }
    }

    /// Whether it is read all the time.
    pub(crate) fn reads_cyclically(self, values: &Values<OBJECTS_MAX>) -> bool {
        match self {
            Self::Ap04 => true,
            Self::Encoder => encoder::reads_cyclically(values),
        }
    }

    /// Whether Reset Node restarts more than the communication.
    pub(crate) fn restarts_on_reset_node(self, values: &Values<OBJECTS_MAX>) -> bool {
        match self {
            Self::Ap04 => true,
            Self::Encoder => encoder::restarts_on_reset_node(values),
        }
    }

    /// What a restore leaves as it is.
    pub(crate) const fn spared_by_restore(self) -> Option<ObjectId> {
        match self {
            Self::Ap04 => Some(profiles::ap04::ZERO_VALUE.id()),
            Self::Encoder => None,
        }
    }

    /// What the next write depends on.
    pub(crate) fn present(self, values: &Values<OBJECTS_MAX>) -> Present {
        match self {
            Self::Ap04 => ap04::present(values),
            Self::Encoder => encoder::present(values),
        }
    }

    /// Does what follows from a number that a master wrote, and names the object that keeps it.
    pub(crate) fn follow(
        self,
        view: &mut View<'_>,
        written: ObjectId,
        before: &Present,
        steps: i64,
    ) -> ObjectId {
        match self {
            Self::Ap04 => ap04::follow(view, written, steps),
            Self::Encoder => encoder::follow(view, written, before, steps),
        }
    }

    /// Brings the values up to date that follow from others and from the shaft.
    pub(crate) fn derive(self, view: &mut View<'_>, steps: i64) {
        match self {
            Self::Ap04 => ap04::derive(view, steps),
            Self::Encoder => encoder::derive(view, steps),
        }
    }
}
