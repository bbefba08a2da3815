//! Cases 6.1 to 6.10: SYNC, consumer and producer.

use crate::Case;
use crate::master::{Lacking, Master, Reason, Sent, Verdict, object};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "6.1", intent: "the identifier in 0x1005", clause: "7.5.2.5", run: case_6_1 },
    Case { number: "6.2", intent: "as many SYNC as 0x1006 says", clause: "7.5.2.6", run: case_6_2 },
    Case { number: "6.3", intent: "a PDO with each SYNC", clause: "7.2.5", run: case_6_3 },
    Case { number: "6.4", intent: "a period of 0 ends production", clause: "7.5.2.6", run: case_6_4 },
    Case { number: "6.5", intent: "a counter that can not be", clause: "7.5.2.22", run: case_6_5 },
    Case { number: "6.6", intent: "no counter", clause: "7.5.2.22", run: case_6_6 },
    Case { number: "6.7", intent: "the counter counts", clause: "7.2.5.2.1", run: case_6_7 },
    Case { number: "6.8", intent: "the counter is stored", clause: "7.5.2.13", run: case_6_8 },
    Case { number: "6.9", intent: "no other counter while SYNC is produced", clause: "7.5.2.22", run: case_6_9 },
    Case { number: "6.10", intent: "period and producer are stored", clause: "7.5.2.13", run: case_6_10 },
];

const SYNC: u16 = 0x080;
const PRODUCER: u32 = 1 << 30;
const PERIOD_US: u32 = 10_000;

/// Synchronization 01: with or without bit 31, which means nothing.
fn case_6_1(master: &mut Master) -> Verdict {
    let object = master.has(0x1005, 0)?;
    assert_eq!(master.number(object) & 0x7FFF_FFFF, u32::from(SYNC));
    Ok(())
}

/// Synchronization 02.
fn case_6_2(master: &mut Master) -> Verdict {
    produce(master)?;
    let count = syncs(&master.watch_ms(1_000)).len();
    assert!((99..=101).contains(&count), "{count} in a second");
    stop(master);
    Ok(())
}

/// Synchronization 03: with every second one too.
fn case_6_3(master: &mut Master) -> Verdict {
    let (cob_id, transmission_type) = synchronous_pdo(master)?;
    let cob_id_before = master.number(cob_id);
    let type_before = master.number(transmission_type);
    let mut verdict = Ok(());
    for every in [1_u8, 2] {
        assert_eq!(master.set(cob_id, cob_id_before | 1 << 31), Ok(()));
        assert_eq!(master.set(transmission_type, u32::from(every)), Ok(()));
        assert_eq!(master.set(cob_id, cob_id_before & !(1 << 31)), Ok(()));
        master.nmt(0x01);
        master.run_ms(20);
        let id = u16::try_from(cob_id_before & 0x7FF).expect("11 bits");
        let mut count = 0;
        for _ in 0..10 {
            master.send(SYNC, &[]);
            count += master.watch_ms(10).iter().filter(|frame| frame.id == id).count();
        }
        if every > 1 && count == 10 {
            verdict = Err(Reason::Deviates("sent with every SYNC".to_owned()));
        } else {
            assert_eq!(count, 10 / usize::from(every));
        }
        master.nmt(0x80);
    }
    assert_eq!(master.set(cob_id, cob_id_before | 1 << 31), Ok(()));
    assert_eq!(master.set(transmission_type, type_before), Ok(()));
    assert_eq!(master.set(cob_id, cob_id_before), Ok(()));
    verdict
}

/// Synchronization 04.
fn case_6_4(master: &mut Master) -> Verdict {
    produce(master)?;
    assert_eq!(master.set(object(0x1006, 0), 0), Ok(()));
    assert_eq!(syncs(&master.watch_ms(200)), Vec::<&Sent>::new());
    stop(master);
    Ok(())
}

/// Synchronization 05.
fn case_6_5(master: &mut Master) -> Verdict {
    let counter = master.writes(0x1019, 0)?;
    for invalid in [1, 241, 255] {
        let code = master.set(counter, invalid).expect_err("it is refused");
        assert_eq!(code & 0xFFFF_FFF0, 0x0609_0030, "{code:08X}");
    }
    Ok(())
}

/// Synchronization 06.
fn case_6_6(master: &mut Master) -> Verdict {
    let counter = master.writes(0x1019, 0)?;
    assert_eq!(master.set(counter, 0), Ok(()));
    produce(master)?;
    let frames = master.watch_ms(100);
    assert!(syncs(&frames).iter().all(|sync| sync.data.is_empty()));
    stop(master);
    Ok(())
}

/// Synchronization 07: from 1 to the overflow value and again from 1.
fn case_6_7(master: &mut Master) -> Verdict {
    let counter = master.writes(0x1019, 0)?;
    assert_eq!(master.set(counter, 4), Ok(()));
    produce(master)?;
    let frames = master.watch_ms(200);
    let counted: Vec<u8> = syncs(&frames).iter().map(|sync| sync.data[0]).collect();
    assert!(counted.len() >= 19, "{counted:?}");
    assert!(counted.windows(2).all(|pair| pair[1] == pair[0] % 4 + 1), "{counted:?}");
    stop(master);
    assert_eq!(master.set(counter, 0), Ok(()));
    Ok(())
}

/// Synchronization 08.
fn case_6_8(master: &mut Master) -> Verdict {
    let counter = master.writes(0x1019, 0)?;
    assert_eq!(master.set(counter, 10), Ok(()));
    crate::store::save(master)?;
    master.restart();
    assert_eq!(master.number(counter), 10);
    crate::store::restore(master)
}

/// Synchronization 09.
fn case_6_9(master: &mut Master) -> Verdict {
    let counter = master.writes(0x1019, 0)?;
    let period = master.writes(0x1006, 0)?;
    assert_eq!(master.set(period, PERIOD_US), Ok(()));
    assert_eq!(master.set(counter, 5), Err(0x0800_0022));
    assert_eq!(master.set(period, 0), Ok(()));
    Ok(())
}

/// Synchronization 10: a device that produced SYNC does so again after power-on.
fn case_6_10(master: &mut Master) -> Verdict {
    produce(master)?;
    crate::store::save(master)?;
    master.restart();
    assert_eq!(master.number(object(0x1006, 0)), PERIOD_US);
    let count = syncs(&master.watch_ms(1_000)).len();
    assert!((99..=101).contains(&count), "{count} in a second");
    crate::store::restore(master)
}

/// Makes the device produce SYNC each 10 ms.
fn produce(master: &mut Master) -> Verdict {
    let period = master.writes(0x1006, 0)?;
    let cob_id = master.writes(0x1005, 0)?;
    assert_eq!(master.set(period, PERIOD_US), Ok(()));
    assert_eq!(master.set(cob_id, u32::from(SYNC) | PRODUCER), Ok(()));
    Ok(())
}

fn stop(master: &mut Master) {
    assert_eq!(master.set(object(0x1005, 0), u32::from(SYNC)), Ok(()));
    assert_eq!(master.set(object(0x1006, 0), 0), Ok(()));
}

fn syncs(frames: &[Sent]) -> Vec<&Sent> {
    frames.iter().filter(|frame| frame.id == SYNC).collect()
}

/// Identifier and transmission type of a transmit PDO that can follow the SYNC.
fn synchronous_pdo(
    master: &mut Master,
) -> Result<(object_dictionary::ObjectId, object_dictionary::ObjectId), Lacking> {
    for index in 0x1800..0x1804 {
        if let (Ok(cob_id), Ok(transmission_type)) =
            (master.writes(index, 1), master.writes(index, 2))
        {
            return Ok((cob_id, transmission_type));
        }
    }
    Err("no transmit PDO has a transmission type that can be chosen".to_owned())
}
