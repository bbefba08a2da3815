//! What this controller keeps without supply (manual 3.5; NM17x STORE-03 to STORE-08): single
//! numbers that are saved with every change, and a set that is saved on command, as a whole.

use canopen::{Node, NodeId};
use heapless::Vec;
use object_dictionary::{Default, Dictionary, ObjectId, Owner, Row, Slot, Storage};
use units::Instant;

use crate::nm17x::Nm17x;
use crate::record::Record;

/// Numbers of the set at most.
const SET_MAX: usize = 32;
/// The node-ID under which the set was saved. Keys of objects are 24 bits; this one lies above.
const SAVED_UNDER: u32 = 1 << 24;
/// The bits of a COB-ID that are a CAN-ID.
const CAN_ID: u32 = 0x7FF;

/// Numbers of 0x1000 to 0x1FFF as they were when they were saved.
#[derive(Clone, Debug, core::default::Default)]
pub(crate) struct Set(Vec<Record, SET_MAX>);

impl Set {
    /// The present numbers of a node.
    pub(crate) fn of<const LEN: usize>(node: &Node<LEN, Nm17x>) -> Self {
        let values = node.values();
        let mut set = Self::default();
        set.add(SAVED_UNDER, node.node_id().get().into());
        for (slot, row) in values.dictionary().slots().filter(|&(_, row)| is_in_set(row)) {
            set.add(row.id().key(), values.raw(slot));
        }
        set
    }

    /// Takes a number in that was saved. Says whether it is one of the set.
    pub(crate) fn restore(&mut self, record: Record, dictionary: &Dictionary) -> bool {
        let row = row_of(record.key, dictionary).map(|(_, row)| row);
        let belongs = record.key == SAVED_UNDER
            || row.is_some_and(|row| is_in_set(row) && row.permits(record.value));
        if belongs {
            self.add(record.key, record.value);
        }
        belongs
    }

    /// Gives a new node the numbers. A CAN-ID that followed the node-ID when it was saved follows
    /// it still.
    pub(crate) fn apply<const LEN: usize>(&self, node: &mut Node<LEN, Nm17x>) {
        let dictionary = node.values().dictionary();
        let saved_under = self.0.iter().find(|record| record.key == SAVED_UNDER);
        let saved_under = saved_under.map_or(node.node_id().get().into(), |record| record.value);
        for record in &self.0 {
            if let Some((slot, row)) = row_of(record.key, dictionary) {
                let value = followed(row, record.value, saved_under, node.node_id());
                node.set_value(Instant::ZERO, slot, value);
            }
        }
    }

    /// The last number of a key counts.
    fn add(&mut self, key: u32, value: u32) {
        self.0.retain(|record| record.key != key);
        let _ = self.0.push(Record { key, value });
    }

    /// The numbers with their keys.
    pub(crate) fn records(&self) -> impl Iterator<Item = Record> {
        self.0.iter().copied()
    }
}

fn is_in_set(row: Row) -> bool {
    row.owner() == Owner::Interface && row.storage() == Storage::OnCommand
}

fn row_of(key: u32, dictionary: &Dictionary) -> Option<(Slot, Row)> {
    let [sub, low, high, above] = key.to_le_bytes();
    let id = ObjectId { index: u16::from_le_bytes([low, high]), sub };
    let slot = dictionary.find(id).ok().filter(|_| above == 0)?;
    Some((slot, dictionary.row(slot)?))
}

fn followed(row: Row, value: u32, saved_under: u32, node_id: NodeId) -> u32 {
    match row.default() {
        Default::NodeIdPlus(base) if value & CAN_ID == (base & CAN_ID) + saved_under => {
            value & !CAN_ID | ((base & CAN_ID) + u32::from(node_id.get()))
        }
        Default::NodeIdPlus(_) | Default::Number(_) | Default::Text(_) => value,
    }
}

#[cfg(test)]
mod tests {
    use profiles::{nm17x, nm170, nm172, nm174};

    use super::*;

    #[test]
    fn the_set_of_every_product_has_room() {
        for dictionary in [&nm170::DICTIONARY, &nm172::DICTIONARY, &nm174::DICTIONARY] {
            let rows = dictionary.rows().filter(|&row| is_in_set(row)).count();
            assert!(rows + 1 < SET_MAX, "{rows}");
        }
    }

    /// NM17x PDO-11, A-15: bits 31 and 30 stay, a CAN-ID of the master's own stays whole.
    #[test]
    fn a_can_id_follows_the_node_id_until_it_is_another() {
        let row = nm172::DICTIONARY.row(nm172::DICTIONARY.slot(&nm17x::TPDO1_COB_ID)).unwrap();
        let node_id = NodeId::new(5).unwrap();
        for (value, expected) in [
            (0xC000_01FF, 0xC000_0185),
            (0x4000_01FF, 0x4000_0185),
            (0x01FF, 0x0185),
            (0x4000_0200, 0x4000_0200),
            (0x4000_0185, 0x4000_0185),
        ] {
            assert_eq!(followed(row, value, 127, node_id), expected, "{value:#x}");
        }
    }
}
