//! Acceptance filters: identifier lists in 16-bit scale, four identifiers a bank, so that a frame
//! for somebody else costs this node nothing. The comparison covers RTR and IDE: remote and
//! extended frames do not match.
//!
//! What controls the node (NMT, SYNC, heartbeats, LSS) goes to FIFO 0, what carries data (SDO, PDO)
//! to FIFO 1, each with a queue of its own: a flood of one leaves the other alone.
use bxcan::filter::ListEntry16;
use bxcan::{Fifo, FilterOwner, Instance, StandardId};

/// Banks of CAN1; the other half belongs to CAN2, which is not used.
const BANKS: u8 = 14;
const IDS_PER_BANK: usize = 4;

/// Identifiers the filters can hold whatever their kinds: each FIFO may leave one bank part full.
pub(super) const ACCEPTED_MAX: usize = (BANKS as usize - 1) * IDS_PER_BANK;

/// Accepts data frames with the 11-bit identifiers `ids`, and nothing else. Identifiers beyond
/// [`ACCEPTED_MAX`] are left out.
pub(super) fn accept<I: Instance + FilterOwner>(can: &mut bxcan::Can<I>, ids: &[u16]) {
    let mut filters = can.modify_filters();
    filters.clear();
    let mut banks = 0..BANKS;
    for fifo in [Fifo::Fifo0, Fifo::Fifo1] {
        let mut entries =
            ids.iter().filter_map(|id| StandardId::new(*id)).filter(|id| fifo_of(*id) == fifo);
        while let Some(first) = entries.next() {
            let Some(bank) = banks.next() else {
                defmt::error!("more identifiers than acceptance filters");
                return;
            };
            // A bank that is not full repeats its first identifier.
            let mut list = [ListEntry16::data_frames_with_id(first); IDS_PER_BANK];
            for (place, id) in list.iter_mut().skip(1).zip(entries.by_ref()) {
                *place = ListEntry16::data_frames_with_id(id);
            }
            filters.enable_bank(bank, fifo, list);
        }
    }
}

/// PDOs and SDOs of the predefined connection set (CiA 301 section 7.3.3).
const DATA_IDS: core::ops::Range<u16> = 0x180..0x680;

fn fifo_of(id: StandardId) -> Fifo {
    if DATA_IDS.contains(&id.as_raw()) { Fifo::Fifo1 } else { Fifo::Fifo0 }
}
