//! Acceptance filters: identifier lists in 16-bit scale, four identifiers a bank, so that a frame
//! for somebody else costs this node nothing. The comparison covers RTR and IDE: a remote frame matches
//! only where it is listened to, an extended one never.
//!
//! What controls the node (NMT, SYNC, heartbeats, LSS) goes to FIFO 0, what carries data (SDO, PDO)
//! to FIFO 1, each with a queue of its own: a flood of one leaves the other alone.
use bxcan::filter::ListEntry16;
use bxcan::{Fifo, FilterOwner, Instance, StandardId};
use canopen::{Accepted, CanId};
use heapless::Vec;

/// Banks of CAN1; the other half belongs to CAN2, which is not used.
const BANKS: u8 = 14;
const IDS_PER_BANK: usize = 4;

/// Accepts the frames `wanted`, and nothing else. What the banks cannot hold is left out.
pub(super) fn accept<I: Instance + FilterOwner>(
    can: &mut bxcan::Can<I>,
    wanted: impl Iterator<Item = Accepted>,
) {
    let mut listed = Vec::<Accepted, { BANKS as usize * IDS_PER_BANK }>::new();
    for frame in wanted {
        if listed.push(frame).is_err() {
            defmt::error!("more identifiers than acceptance filters");
        }
    }
    let mut filters = can.modify_filters();
    filters.clear();
    let mut banks = 0..BANKS;
    for fifo in [Fifo::Fifo0, Fifo::Fifo1] {
        let mut entries = listed.iter().filter(|frame| fifo_of(frame.id) == fifo).map(entry);
        while let Some(first) = entries.next() {
            let Some(bank) = banks.next() else {
                defmt::error!("more identifiers than acceptance filters");
                return;
            };
            // A bank that is not full repeats its first identifier.
            let mut list = [first; IDS_PER_BANK];
            for (place, entry) in list.iter_mut().skip(1).zip(entries.by_ref()) {
                *place = entry;
            }
            filters.enable_bank(bank, fifo, list);
        }
    }
}

fn entry(frame: &Accepted) -> ListEntry16 {
    let id = StandardId::new(frame.id.get()).unwrap_or(StandardId::MAX);
    if frame.remote {
        ListEntry16::remote_frames_with_id(id)
    } else {
        ListEntry16::data_frames_with_id(id)
    }
}

/// PDOs and SDOs of the predefined connection set (CiA 301 section 7.3.3).
const DATA_IDS: core::ops::Range<u16> = 0x180..0x680;

fn fifo_of(id: CanId) -> Fifo {
    if DATA_IDS.contains(&id.get()) { Fifo::Fifo1 } else { Fifo::Fifo0 }
}
