//! Cases 3.1 to 3.33: PDOs and their mapping.

use object_dictionary::{Access, ObjectId, PdoMapping, Row};

use crate::Case;
use crate::master::{AbortCode, Lacking, Master, Reason, Sent, Verdict, name, object, refused};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "3.1", intent: "parameters of the receive PDOs", clause: "7.5.2.35", run: case_3_1 },
    Case { number: "3.2", intent: "parameters of the transmit PDOs", clause: "7.5.2.37", run: case_3_2 },
    Case { number: "3.3", intent: "Operational: a remote frame", clause: "7.2.2.2.2", run: case_3_3 },
    Case { number: "3.4", intent: "Operational: event-driven", clause: "7.2.2.2.1", run: case_3_4 },
    Case { number: "3.5", intent: "Operational: event timer", clause: "7.2.2.2.1", run: case_3_5 },
    Case { number: "3.6", intent: "Operational: cyclic with SYNC", clause: "7.2.2.2.1", run: case_3_6 },
    Case { number: "3.7", intent: "Operational: acyclic with SYNC", clause: "7.2.2.2.1", run: case_3_7 },
    Case { number: "3.8", intent: "Operational: SYNC start value", clause: "7.5.2.37", run: case_3_8 },
    Case { number: "3.9", intent: "Stopped: a remote frame", clause: "7.3.2.2.4", run: case_3_9 },
    Case { number: "3.10", intent: "Stopped: event-driven", clause: "7.3.2.2.4", run: case_3_10 },
    Case { number: "3.11", intent: "Stopped: event timer", clause: "7.3.2.2.4", run: case_3_11 },
    Case { number: "3.12", intent: "Stopped: cyclic with SYNC", clause: "7.3.2.2.4", run: case_3_12 },
    Case { number: "3.13", intent: "Stopped: acyclic with SYNC", clause: "7.3.2.2.4", run: case_3_13 },
    Case { number: "3.14", intent: "Stopped: SYNC start value", clause: "7.3.2.2.4", run: case_3_14 },
    Case { number: "3.15", intent: "Pre-operational: a remote frame", clause: "7.3.2.2.2", run: case_3_15 },
    Case { number: "3.16", intent: "Pre-operational: event-driven", clause: "7.3.2.2.2", run: case_3_16 },
    Case { number: "3.17", intent: "Pre-operational: event timer", clause: "7.3.2.2.2", run: case_3_17 },
    Case { number: "3.18", intent: "Pre-operational: cyclic with SYNC", clause: "7.3.2.2.2", run: case_3_18 },
    Case { number: "3.19", intent: "Pre-operational: acyclic with SYNC", clause: "7.3.2.2.2", run: case_3_19 },
    Case { number: "3.20", intent: "Pre-operational: SYNC start value", clause: "7.3.2.2.2", run: case_3_20 },
    Case { number: "3.21", intent: "the mapping at delivery", clause: "7.5.2.36", run: case_3_21 },
    Case { number: "3.22", intent: "a new mapping", clause: "7.5.2.38", run: case_3_22 },
    Case { number: "3.23", intent: "a new entry while the mapping is in force", clause: "7.5.2.38", run: case_3_23 },
    Case { number: "3.24", intent: "a new mapping while the PDO is valid", clause: "7.5.2.38", run: case_3_24 },
    Case { number: "3.25", intent: "too many objects", clause: "7.5.2.38", run: case_3_25 },
    Case { number: "3.26", intent: "objects that are too long together", clause: "7.5.2.38", run: case_3_26 },
    Case { number: "3.27", intent: "an output in a receive PDO", clause: "7.4.8.2", run: case_3_27 },
    Case { number: "3.28", intent: "an input in a receive PDO", clause: "7.4.8.2", run: case_3_28 },
    Case { number: "3.29", intent: "in a receive PDO, what may be in none", clause: "7.4.8.2", run: case_3_29 },
    Case { number: "3.30", intent: "an input in a transmit PDO", clause: "7.4.8.2", run: case_3_30 },
    Case { number: "3.31", intent: "an output in a transmit PDO", clause: "7.4.8.2", run: case_3_31 },
    Case { number: "3.32", intent: "in a transmit PDO, what may be in none", clause: "7.4.8.2", run: case_3_32 },
    Case { number: "3.33", intent: "a dummy entry", clause: "7.4.7.1", run: case_3_33 },
];

const SYNC: u16 = 0x080;
const INVALID: u32 = 1 << 31;
const NO_REMOTE: u32 = 1 << 30;

const START: u8 = 0x01;
const STOP: u8 = 0x02;
const ENTER_PRE_OPERATIONAL: u8 = 0x80;

/// What a mapping that can not be is refused with.
const BAD_MAPPING: &[AbortCode] = &[0x0602_0000, 0x0604_0041, 0x0604_0042];

/// What starts a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Remote,
    Event,
    Timer,
    Cyclic,
    Acyclic,
    StartValue,
}

/// PDO 01.
fn case_3_1(master: &mut Master) -> Verdict {
    parameters(master, 0x1400, 0x1600, 2)
}

/// PDO 02.
fn case_3_2(master: &mut Master) -> Verdict {
    parameters(master, 0x1800, 0x1A00, 2)
}

/// PDO 03.
fn case_3_3(master: &mut Master) -> Verdict {
    sent_in(master, START, Kind::Remote)
}

/// PDO 04.
fn case_3_4(master: &mut Master) -> Verdict {
    sent_in(master, START, Kind::Event)
}

/// PDO 05.
fn case_3_5(master: &mut Master) -> Verdict {
    sent_in(master, START, Kind::Timer)
}

/// PDO 06.
fn case_3_6(master: &mut Master) -> Verdict {
    sent_in(master, START, Kind::Cyclic)
}

/// PDO 07.
fn case_3_7(master: &mut Master) -> Verdict {
    sent_in(master, START, Kind::Acyclic)
}

/// PDO 08.
fn case_3_8(master: &mut Master) -> Verdict {
    sent_in(master, START, Kind::StartValue)
}

/// PDO 09.
fn case_3_9(master: &mut Master) -> Verdict {
    sent_in(master, STOP, Kind::Remote)
}

/// PDO 10.
fn case_3_10(master: &mut Master) -> Verdict {
    sent_in(master, STOP, Kind::Event)
}

/// PDO 11.
fn case_3_11(master: &mut Master) -> Verdict {
    sent_in(master, STOP, Kind::Timer)
}

/// PDO 12.
fn case_3_12(master: &mut Master) -> Verdict {
    sent_in(master, STOP, Kind::Cyclic)
}

/// PDO 13.
fn case_3_13(master: &mut Master) -> Verdict {
    sent_in(master, STOP, Kind::Acyclic)
}

/// PDO 14.
fn case_3_14(master: &mut Master) -> Verdict {
    sent_in(master, STOP, Kind::StartValue)
}

/// PDO 15.
fn case_3_15(master: &mut Master) -> Verdict {
    sent_in(master, ENTER_PRE_OPERATIONAL, Kind::Remote)
}

/// PDO 16.
fn case_3_16(master: &mut Master) -> Verdict {
    sent_in(master, ENTER_PRE_OPERATIONAL, Kind::Event)
}

/// PDO 17.
fn case_3_17(master: &mut Master) -> Verdict {
    sent_in(master, ENTER_PRE_OPERATIONAL, Kind::Timer)
}

/// PDO 18.
fn case_3_18(master: &mut Master) -> Verdict {
    sent_in(master, ENTER_PRE_OPERATIONAL, Kind::Cyclic)
}

/// PDO 19.
fn case_3_19(master: &mut Master) -> Verdict {
    sent_in(master, ENTER_PRE_OPERATIONAL, Kind::Acyclic)
}

/// PDO 20.
fn case_3_20(master: &mut Master) -> Verdict {
    sent_in(master, ENTER_PRE_OPERATIONAL, Kind::StartValue)
}

/// PDO 21: objects that exist, at their whole length, and no more than eight bytes.
fn case_3_21(master: &mut Master) -> Verdict {
    let mappings = (0x1600..0x1604).chain(0x1A00..0x1A04);
    let present: Vec<u16> = mappings.filter(|&index| master.has(index, 0).is_ok()).collect();
    for index in present {
        let count = master.number(object(index, 0));
        let mut bits_in_all = 0;
        for sub in (1..=8).take(usize::try_from(count).expect("a count")) {
            let [bits, mapped_sub, low, high] = master.number(object(index, sub)).to_le_bytes();
            let mapped = object(u16::from_le_bytes([low, high]), mapped_sub);
            let Some(row) = master.row(mapped) else {
                return Err(Reason::Deviates(format!("no object {}", name(mapped))));
            };
            assert_eq!(8 * row.data_type().len(), usize::from(bits), "{}", name(mapped));
            bits_in_all += u32::from(bits);
        }
        assert!(bits_in_all <= 64);
    }
    Ok(())
}

/// PDO 22: the PDO then carries what was mapped.
fn case_3_22(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    let [first, second, ..] = mappable(master, PdoMapping::Transmit)[..] else {
        return Err("fewer than two objects may be in transmit PDOs".into());
    };
    let communication = index - 0x1A00 + 0x1800;
    assert_eq!(map(master, index, &[entry(second), entry(first)]), Ok(()));
    let before = event_driven(master, communication)?;
    let frames = master.watch(500, |master| master.nmt(START));
    let len = first.data_type().len() + second.data_type().len();
    let sent: Vec<_> =
        frames.iter().filter(|frame| u32::from(frame.id) == before & 0x7FF).collect();
    assert!(!sent.is_empty() && sent.iter().all(|frame| frame.data.len() == len), "{sent:02X?}");
    master.restart();
    Ok(())
}

/// PDO 23.
fn case_3_23(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    let cob_id = invalidate(master, index - 0x1A00 + 0x1800)?;
    let row = mappable(master, PdoMapping::Transmit)[0];
    assert!(master.set(object(index, 1), entry(row)).is_err(), "{cob_id:08X}");
    master.restart();
    Ok(())
}

/// PDO 24.
fn case_3_24(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    let count = master.number(object(index, 0));
    assert!(master.set(object(index, 0), 0).is_err());
    assert_eq!(master.number(object(index, 0)), count);
    Ok(())
}

/// PDO 25.
fn case_3_25(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    invalidate(master, index - 0x1A00 + 0x1800)?;
    assert_eq!(master.set(object(index, 0), 0), Ok(()));
    let written = master.set(object(index, 0), 65);
    master.restart();
    refused(written, BAD_MAPPING)
}

/// PDO 26.
fn case_3_26(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    let row = mappable(master, PdoMapping::Transmit)[0];
    let too_many = 8 / row.data_type().len() + 1;
    badly_mapped(master, index, &vec![entry(row); too_many])
}

/// PDO 27.
fn case_3_27(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1600)?;
    let row = mappable(master, PdoMapping::Receive)[0];
    assert_eq!(map(master, index, &[entry(row)]), Ok(()));
    master.restart();
    Ok(())
}

/// PDO 28.
fn case_3_28(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1600)?;
    let inputs = mappable(master, PdoMapping::Transmit);
    let input = inputs.into_iter().find(|row| row.access() == Access::ReadOnly);
    let input = input.ok_or("every object in transmit PDOs is rw")?;
    badly_mapped(master, index, &[entry(input)])
}

/// PDO 29.
fn case_3_29(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1600)?;
    badly_mapped(master, index, &[0x1017_0010])
}

/// PDO 30.
fn case_3_30(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    let row = mappable(master, PdoMapping::Transmit)[0];
    assert_eq!(map(master, index, &[entry(row)]), Ok(()));
    master.restart();
    Ok(())
}

/// PDO 31.
fn case_3_31(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    let outputs = mappable(master, PdoMapping::Receive);
    let output = outputs.into_iter().find(|row| row.pdo() == PdoMapping::Receive);
    let output = output.ok_or("every output may be in transmit PDOs too")?;
    badly_mapped(master, index, &[entry(output)])
}

/// PDO 32.
fn case_3_32(master: &mut Master) -> Verdict {
    let index = dynamic(master, 0x1A00)?;
    badly_mapped(master, index, &[0x1017_0010])
}

/// PDO 33: eight bits that nobody takes.
fn case_3_33(master: &mut Master) -> Verdict {
    const UNSIGNED8: u32 = 0x0005_0008;
    let index = dynamic(master, 0x1600)?;
    let row = mappable(master, PdoMapping::Receive)[0];
    assert_eq!(map(master, index, &[UNSIGNED8, entry(row)]), Ok(()));
    master.restart();
    Ok(())
}

/// Whether each PDO has what it needs, and the number of its last sub-index.
fn parameters(master: &mut Master, communication: u16, mapping: u16, subs_min: u32) -> Verdict {
    let mut any = false;
    for number in 0..512 {
        let index = communication + number;
        if master.has(index, 0).is_err() {
            assert_eq!(master.upload(object(index, 0)), Err(0x0602_0000), "{index:#06x}");
            if number >= 8 {
                break;
            }
            continue;
        }
        any = true;
        assert!(master.number(object(index, 0)) >= subs_min);
        assert_eq!(master.number(object(index, 1)) & 1 << 29, 0, "eleven bits");
        let transmission_type = master.number(object(index, 2));
        assert!(matches!(transmission_type, 0..=240 | 252..=255));
        assert!(master.number(object(mapping + number, 0)) <= 8);
    }
    if any { Ok(()) } else { Err("no such PDO".into()) }
}

/// Whether PDOs that are started this way go out in Operational, and in no other state.
fn sent_in(master: &mut Master, command: u8, kind: Kind) -> Verdict {
    let mut verdict = Err(Reason::from("no transmit PDO"));
    let indexes: Vec<u16> =
        (0x1800..0x1804).filter(|&index| master.has(index, 1).is_ok()).collect();
    for index in indexes {
        match configure(master, index, kind) {
            Ok(configured) => {
                master.nmt(command);
                master.watch_ms(100);
                let stimulated = stimulate(master, &configured, kind, command == START);
                master.nmt(ENTER_PRE_OPERATIONAL);
                undo(master, &configured);
                stimulated?;
                verdict = Ok(());
            }
            Err(lacking) => verdict = verdict.map_err(|_| lacking.into()),
        }
    }
    verdict
}

/// A PDO as it is for one case, and how it was.
struct Configured {
    index: u16,
    id: u16,
    before: Vec<(ObjectId, u32)>,
}

fn configure(master: &mut Master, index: u16, kind: Kind) -> Result<Configured, Lacking> {
    let cob_id = master.writes(index, 1)?;
    let was = master.number(cob_id);
    let mut configured = Configured {
        index,
        id: u16::try_from(was & 0x7FF).expect("11 bits"),
        before: vec![(cob_id, was)],
    };
    let settings: &[(u8, u32)] = match kind {
        Kind::Remote => master.device.remote.map_err(str::to_owned)?,
        Kind::Event => &[(2, master.device.follows_changes.map_err(str::to_owned)?)],
        Kind::Timer => &[(2, 254), (5, 100)],
        Kind::Cyclic => &[(2, 2)],
        Kind::Acyclic => &[(2, 0)],
        Kind::StartValue => &[(2, 1), (6, 3)],
    };
    for &(sub, value) in settings {
        let setting = match master.writes(index, sub) {
            Err(_)
                if master.has(index, sub).is_ok() && master.number(object(index, sub)) == value =>
            {
                continue;
            }
            writable => writable?,
        };
        configured.before.push((setting, master.number(setting)));
    }
    if let (Kind::Event | Kind::Acyclic, Ok(mapping)) =
        (kind, master.writes(index - 0x1800 + 0x1A00, 0))
    {
        assert_eq!(map(master, mapping.index, &[entry(changing(master))]), Ok(()));
    }
    assert_eq!(master.set(cob_id, was | INVALID), Ok(()));
    for &(sub, value) in settings {
        if master.number(object(index, sub)) == value {
            continue;
        }
        if let Err(code) = master.set(object(index, sub), value) {
            undo(master, &configured);
            assert_eq!(code & 0xFFFF_FFF0, 0x0609_0030, "{code:08X}");
            return Err(format!("{} does not take {value}", name(object(index, sub))));
        }
    }
    let valid = match kind {
        Kind::Remote => was & !(INVALID | NO_REMOTE),
        Kind::Event | Kind::Timer | Kind::Cyclic | Kind::Acyclic | Kind::StartValue => {
            was & !INVALID
        }
    };
    let taken = master.set(cob_id, valid);
    if kind == Kind::Remote && (taken.is_err() || master.number(cob_id) & NO_REMOTE != 0) {
        undo(master, &configured);
        return Err("remote frames are not answered: bit 30 of the COB-ID stays 1".to_owned());
    }
    assert_eq!(taken, Ok(()));
    if kind == Kind::StartValue {
        let counter = master.writes(0x1019, 0)?;
        assert_eq!(master.set(counter, 10), Ok(()));
        configured.before.push((counter, 0));
    }
    Ok(configured)
}

/// Puts everything back: the identifier last.
fn undo(master: &mut Master, configured: &Configured) {
    let cob_id = object(configured.index, 1);
    let was = configured.before[0].1;
    assert_eq!(master.set(cob_id, was | INVALID), Ok(()));
    for &(object, value) in configured.before.iter().skip(1).rev() {
        assert_eq!(master.set(object, value), Ok(()), "{}", name(object));
    }
    assert_eq!(master.set(cob_id, was), Ok(()));
}

/// Does what starts the PDO, and counts.
fn stimulate(master: &mut Master, configured: &Configured, kind: Kind, running: bool) -> Verdict {
    let id = configured.id;
    let count = |frames: &[Sent]| frames.iter().filter(|sent| sent.id == id).count();
    let sync = |master: &mut Master, data: &[u8]| {
        master.send(SYNC, data);
        count(&master.watch_ms(20))
    };
    let expected = |full: usize| if running { full } else { 0 };
    match kind {
        Kind::Remote => {
            master.send_remote(id);
            assert_eq!(count(&master.watch_ms(20)), expected(1));
        }
        Kind::Event => {
            let frames = master.watch(300, |master| change(master, running));
            assert_eq!(count(&frames).min(1), expected(1));
        }
        Kind::Timer => {
            let sent = count(&master.watch_ms(1_000));
            let bounds = if running { 9..=11 } else { 0..=0 };
            assert!(bounds.contains(&sent), "{sent} in a second");
        }
        Kind::Cyclic => {
            let sent: usize = (0..10).map(|_| sync(master, &[])).sum();
            if sent == expected(10) && running {
                return Err(Reason::Deviates("sent with every SYNC".to_owned()));
            }
            assert_eq!(sent, expected(5));
        }
        Kind::Acyclic => {
            // What a start counts as a change goes out with the first SYNC.
            sync(master, &[]);
            assert_eq!(sync(master, &[]), 0, "nothing changed");
            change(master, running);
            master.run_ms(50);
            assert_eq!((sync(master, &[]), sync(master, &[])), (expected(1), 0));
        }
        Kind::StartValue => {
            let sent: Vec<usize> = (1..=6).map(|counter| sync(master, &[counter])).collect();
            assert_eq!(sent, [0, 0, expected(1), expected(1), expected(1), expected(1)]);
        }
    }
    Ok(())
}

/// Changes what the PDO carries, as far as the state allows it.
fn change(master: &mut Master, running: bool) {
    match master.device.output {
        Some(output) if running => {
            let value = master.number(output);
            assert_eq!(master.set(output, value ^ 1), Ok(()));
        }
        Some(_) => {}
        None => master.turn_shaft(),
    }
}

/// The object that [`change`] changes, where a PDO can be made to carry it.
fn changing(master: &Master) -> Row {
    let output = master.device.output.expect("a device with dynamic mapping has an output");
    master.row(output).expect("the output is there")
}

/// The mapping object of a PDO, if masters may change it.
fn dynamic(master: &mut Master, mapping: u16) -> Result<u16, Lacking> {
    master.writes(mapping, 0).map_err(|_| "the mapping is fixed".to_owned())?;
    Ok(mapping)
}

fn mappable(master: &Master, direction: PdoMapping) -> Vec<Row> {
    let mappable = |row: &Row| row.pdo() == direction || row.pdo() == PdoMapping::Both;
    master.rows().filter(mappable).collect()
}

/// The mapping entry for an object.
fn entry(row: Row) -> u32 {
    let bits = u32::try_from(8 * row.data_type().len()).expect("a short object");
    u32::from(row.id().index) << 16 | u32::from(row.id().sub) << 8 | bits
}

/// Switches a PDO off and says what its COB-ID was.
fn invalidate(master: &mut Master, communication: u16) -> Result<u32, Lacking> {
    let cob_id = master.writes(communication, 1)?;
    let was = master.number(cob_id);
    assert_eq!(master.set(cob_id, was | INVALID), Ok(()));
    Ok(was)
}

/// Maps by the procedure of CiA 301, section 7.5.2.38.
fn map(master: &mut Master, index: u16, entries: &[u32]) -> Result<(), AbortCode> {
    let communication =
        if index < 0x1A00 { index - 0x1600 + 0x1400 } else { index - 0x1A00 + 0x1800 };
    let was = invalidate(master, communication).expect("a dynamic PDO can be switched off");
    master.set(object(index, 0), 0)?;
    for (sub, &entry) in (1..).zip(entries) {
        master.set(object(index, sub), entry)?;
    }
    master.set(object(index, 0), u32::try_from(entries.len()).expect("at most 8"))?;
    master.set(object(communication, 1), was)
}

fn badly_mapped(master: &mut Master, index: u16, entries: &[u32]) -> Verdict {
    let mapped = map(master, index, entries);
    master.restart();
    refused(mapped, BAD_MAPPING)
}

/// Lets a PDO follow changes, and says what its COB-ID was.
fn event_driven(master: &mut Master, communication: u16) -> Result<u32, Lacking> {
    let was = invalidate(master, communication)?;
    assert_eq!(master.set(object(communication, 2), 255), Ok(()));
    assert_eq!(master.set(object(communication, 1), was), Ok(()));
    Ok(was)
}
