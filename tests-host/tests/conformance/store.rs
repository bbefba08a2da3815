//! Cases 8.1 to 8.10: store, restore, restricted identifiers.

use crate::Case;
use crate::master::{Lacking, Master, Reason, Verdict, object, refused};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "8.1", intent: "a value that is not stored is lost", clause: "7.5.2.13", run: case_8_1 },
    Case { number: "8.2", intent: "a stored value outlives a reset", clause: "7.5.2.13", run: case_8_2 },
    Case { number: "8.3", intent: "restore with the wrong signature", clause: "7.5.2.14", run: case_8_3 },
    Case { number: "8.4", intent: "restore takes effect with the reset", clause: "7.5.2.14", run: case_8_4 },
    Case { number: "8.5", intent: "a communication parameter that is not stored is lost", clause: "7.5.2.13", run: case_8_5 },
    Case { number: "8.6", intent: "a stored communication parameter outlives a reset", clause: "7.5.2.13", run: case_8_6 },
    Case { number: "8.7", intent: "restore of the communication with the wrong signature", clause: "7.5.2.14", run: case_8_7 },
    Case { number: "8.8", intent: "restore of the communication", clause: "7.5.2.14", run: case_8_8 },
    Case { number: "8.9", intent: "the date of the configuration", clause: "7.5.2.23", run: case_8_9 },
    Case { number: "8.10", intent: "restricted identifiers", clause: "7.3.5", run: case_8_10 },
];

const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");
const WRONG: u32 = u32::from_le_bytes(*b"wron");
const WRONG_SIGNATURE: u32 = 0x0800_0020;
/// All parameters, and those of the communication.
const ALL: u8 = 1;
const COMMUNICATION: u8 = 2;

/// Testing other 01.
fn case_8_1(master: &mut Master) -> Verdict {
    is_lost(master, ALL)
}

/// Testing other 02.
fn case_8_2(master: &mut Master) -> Verdict {
    outlives(master, ALL)
}

/// Testing other 03.
fn case_8_3(master: &mut Master) -> Verdict {
    needs_its_signature(master, ALL)
}

/// Testing other 04.
fn case_8_4(master: &mut Master) -> Verdict {
    is_restored(master, ALL)
}

/// Testing other 05.
fn case_8_5(master: &mut Master) -> Verdict {
    is_lost(master, COMMUNICATION)
}

/// Testing other 06.
fn case_8_6(master: &mut Master) -> Verdict {
    outlives(master, COMMUNICATION)
}

/// Testing other 07.
fn case_8_7(master: &mut Master) -> Verdict {
    needs_its_signature(master, COMMUNICATION)
}

/// Testing other 08.
fn case_8_8(master: &mut Master) -> Verdict {
    is_restored(master, COMMUNICATION)
}

/// Testing other 09.
fn case_8_9(master: &mut Master) -> Verdict {
    master.has(0x1020, 1)?;
    unreachable!("none of the products keeps the date")
}

/// Testing other 10.
fn case_8_10(master: &mut Master) -> Verdict {
    let own = [0x1005, 0x1014];
    let objects: Vec<_> = own
        .into_iter()
        .map(|index| (index, 0))
        .chain((0x1400..0x1404).chain(0x1800..0x1804).map(|index| (index, 1)))
        .filter_map(|(index, sub)| master.writes(index, sub).ok())
        .collect();
    for object in objects {
        let before = master.number(object);
        for restricted in [0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701] {
            let cob_id = before & !0x7FF | restricted;
            let written = master.set(object, cob_id);
            if written.is_ok() {
                assert_eq!(master.set(object, before | 1 << 31), Ok(()));
                assert_eq!(master.set(object, before), Ok(()));
            }
            refused(written, &[0x0609_0030, 0x0609_0031, 0x0609_0032])?;
        }
    }
    Ok(())
}

/// Saves all parameters.
pub(crate) fn save(master: &mut Master) -> Verdict {
    let store = master.writes(0x1010, ALL)?;
    assert_eq!(master.set(store, SAVE), Ok(()));
    Ok(())
}

/// Everything as at delivery.
pub(crate) fn restore(master: &mut Master) -> Verdict {
    let restore = master.writes(0x1011, ALL)?;
    assert_eq!(master.set(restore, LOAD), Ok(()));
    master.restart();
    Ok(())
}

/// An object that is stored on command, and a value for it.
fn stored(master: &Master) -> Result<(object_dictionary::ObjectId, u32), Lacking> {
    master.device.stored.ok_or_else(|| "every value is stored at once".into())
}

fn is_lost(master: &mut Master, area: u8) -> Verdict {
    master.writes(0x1010, area)?;
    let (object, value) = stored(master)?;
    let before = master.number(object);
    assert_eq!(master.set(object, value), Ok(()));
    master.restart();
    assert_eq!(master.number(object), before);
    Ok(())
}

fn outlives(master: &mut Master, area: u8) -> Verdict {
    let store = master.writes(0x1010, area)?;
    let (object, value) = stored(master)?;
    assert_eq!(master.set(object, value), Ok(()));
    assert_eq!(master.set(store, WRONG), Err(WRONG_SIGNATURE));
    assert_eq!(master.set(store, SAVE), Ok(()));
    master.restart();
    assert_eq!(master.number(object), value);
    restore(master)
}

fn needs_its_signature(master: &mut Master, area: u8) -> Verdict {
    let restore = master.writes(0x1011, area)?;
    assert_eq!(master.set(restore, WRONG), Err(WRONG_SIGNATURE));
    Ok(())
}

/// The values stay until the reset, and are those at delivery from then on.
fn is_restored(master: &mut Master, area: u8) -> Verdict {
    let load = master.writes(0x1011, area)?;
    let (object, value) = match stored(master) {
        Ok(stored) => stored,
        Err(_) => (object(0x1017, 0), 777),
    };
    let default = master.number(object);
    assert_eq!(master.set(object, value), Ok(()));
    if master.device.stored.is_some() {
        save(master)?;
    }
    assert_eq!(master.set(load, LOAD), Ok(()));
    let at_once = master.number(object) != value;
    master.restart();
    assert_eq!(master.number(object), default);
    if at_once { Err(Reason::Deviates("restored at once".to_owned())) } else { Ok(()) }
}
