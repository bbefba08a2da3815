//! What a store keeps, what it refuses, what it costs and how it takes decayed memory.
use crate::nor::{LEN, Nor, SECTORS, SmallNor};
use embassy_futures::block_on;
use std::collections::BTreeMap;
use storage::{Error, Opened, RECORD_KEY_MAX, Record, SET_LEN_MAX, Store, Stored, Value};

fn all<const SECTOR: usize>(flash: &mut Nor<SECTOR>) -> (BTreeMap<u32, Value>, Opened) {
    let (mut store, opened) = block_on(Store::open(flash, 0..(SECTOR * SECTORS) as u32)).unwrap();
    let mut found = BTreeMap::new();
    block_on(store.load_all(|record| {
        found.insert(record.key, record.value);
    }))
    .unwrap();
    (found, opened)
}

#[test]
fn values_of_every_length_come_back() {
    let mut flash = Nor::<1024>::new(1);
    let text = |len: usize| Value::from_bytes(&b"1234567890AB-_xy"[..len]).unwrap();
    let (mut store, _) = block_on(Store::open(&mut flash, 0..4096)).unwrap();
    for len in 0..=16 {
        let record = Record { key: (0x2007 << 8) + len as u32, value: text(len) };
        block_on(store.store(&record)).unwrap();
    }
    let (found, opened) = all(&mut flash);
    assert_eq!(opened, Opened::Intact);
    assert_eq!(found.into_values().collect::<Vec<_>>(), (0..=16).map(text).collect::<Vec<_>>());
    assert_eq!(Value::from_bytes(&[0; 17]), None);
    assert_eq!(Value::from(0x0001_86A0).as_u32(), Some(100_000));
    assert_eq!(text(3).as_u32(), None);
}

#[test]
fn what_is_no_record_is_refused() {
    let mut flash = Nor::<2048>::new(1);
    let value = Value::from(1);
    for range in [0..2048, 0..10_240, 0..4_000, 1_024..5_120] {
        let refused = block_on(Store::open(&mut flash, range.clone())).map(|(_, opened)| opened);
        assert_eq!(refused, Err(Error::Flash), "{range:?}");
    }
    let (mut store, _) = block_on(Store::open(&mut flash, 0..8_192)).unwrap();
    let key = RECORD_KEY_MAX + 1;
    assert_eq!(block_on(store.store(&Record { key, value })), Err(Error::NotARecord));
    assert_eq!(block_on(store.store_all([Record { key, value }])), Err(Error::NotARecord));
    let most = SET_LEN_MAX as u32 / 9;
    let set = |count| (0..count).map(|key| Record { key, value });
    assert_eq!(block_on(store.store_all(set(most + 1))), Err(Error::NotARecord));
    block_on(store.store_all(set(most))).unwrap();
    assert_eq!(all(&mut flash).0.len(), most as usize);
}

/// Three of the four sectors can be full of different keys. One more is refused, and the store goes
/// on serving the others.
#[test]
fn a_full_store_keeps_what_it_has() {
    let mut flash = SmallNor::new(1);
    let (mut store, _) = block_on(Store::open(&mut flash, 0..LEN as u32)).unwrap();
    let record = |key| Record { key, value: Value::from(key) };
    let refused = (0..100).find(|&key| block_on(store.store(&record(key))) == Err(Error::Full));
    let kept = refused.expect("a hundred records do not fit");
    let (found, _) = all(&mut flash);
    assert!((0..kept).all(|key| found.get(&key) == Some(&Value::from(key))), "{found:?}");
}

/// One decayed cell costs at most the record it lies in: that falls back to its value before or to
/// none. Markers and stamps have bits to spare.
#[test]
fn a_decayed_bit_costs_at_most_one_record() {
    let mut flash = SmallNor::new(1);
    let (mut store, _) = block_on(Store::open(&mut flash, 0..LEN as u32)).unwrap();
    let newest = |key: u32| Value::from(0x0101_0000 * 3 + key);
    for version in 1..=3_u32 {
        for key in 0..5 {
            let value = Value::from(0x0101_0000 * version + key);
            block_on(store.store(&Record { key, value })).unwrap();
        }
    }
    for bit in 0..LEN * 8 {
        let mut decayed = flash.powered();
        decayed.bytes[bit / 8] ^= 1 << (bit % 8);
        let (found, opened) = all(&mut decayed);
        assert_eq!(opened, Opened::Intact, "bit {bit}");
        let wrong = (0..5).filter(|key| found.get(key) != Some(&newest(*key))).collect::<Vec<_>>();
        assert!(wrong.len() <= 1, "bit {bit}: {wrong:?} of {found:?}");
        for key in wrong {
            let older = [1, 2].map(|version| Value::from(0x0101_0000 * version + key));
            assert!(found.get(&key).is_none_or(|value| older.contains(value)), "bit {bit}");
        }
    }
}

/// Anything at all in the sectors, with and without the stamps of a store: it opens, and works as
/// new where the stamps were missing.
#[test]
fn any_memory_content_can_be_opened() {
    let record = Record { key: 9, value: Value::from(7) };
    for seed in 1..400_u64 {
        let mut flash = SmallNor::new(seed);
        let mut random = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        for byte in &mut flash.bytes {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            *byte =
                if seed % 3 == 0 { (random >> 40) as u8 } else { [0, 0xFF][(random & 1) as usize] };
        }
        let stamped = seed % 2 == 0;
        if stamped {
            for (at, byte) in all_stamps() {
                flash.bytes[at] = byte;
            }
        }
        let (mut store, opened) = block_on(Store::open(&mut flash, 0..LEN as u32)).unwrap();
        assert_ne!(opened, Opened::Blank, "seed {seed}");
        let stored = block_on(store.store(&record));
        block_on(store.load_all(|_| ())).unwrap_or_else(|e| panic!("seed {seed}: {e:?}"));
        if !stamped {
            assert_eq!(stored, Ok(Stored::Written), "seed {seed}");
            let only = BTreeMap::from([(record.key, record.value)]);
            assert_eq!(all(&mut flash).0, only, "seed {seed}");
        }
    }
}

/// The stamps as a store leaves them.
fn all_stamps() -> Vec<(usize, u8)> {
    let mut flash = SmallNor::new(1);
    all(&mut flash);
    flash.bytes.into_iter().enumerate().filter(|&(_, byte)| byte != 0xFF).collect()
}

/// NM17x STORE-01: one million stores. Forty parameters in four sectors of 16 KB cost one erase per
/// 775 stores, spread evenly: 10 000 cycles per sector last for 31 million stores.
#[test]
fn wear_is_low_and_even() {
    const STORES: u32 = 20_000;
    let mut flash = Nor::<16_384>::new(1);
    let (mut store, _) = block_on(Store::open(&mut flash, 0..65_536)).unwrap();
    for round in 0..STORES {
        let record = Record { key: (0x2000 << 8) + round % 40, value: Value::from(round) };
        block_on(store.store(&record)).unwrap();
    }
    let (most, least) = (flash.erases.iter().max().unwrap(), flash.erases.iter().min().unwrap());
    assert!(most - least <= 1, "{:?}", flash.erases);
    let erases: u32 = flash.erases.iter().sum();
    assert!(STORES / erases >= 775, "{STORES} stores, {erases} erases");
}
