//! The supply is cut in the middle of every single flash operation, and once more in the middle of
//! every operation of the recovery: the old value or the new one is found, never a third, and no
//! other record changes.
use crate::nor::{LEN, SmallNor};
use embassy_futures::block_on;
use proptest::prelude::*;
use std::collections::BTreeMap;
use storage::{Error, Opened, Record, Store, Stored, Value};

/// What a memory holds: single records and set alike.
type Contents = BTreeMap<u32, Value>;

/// The seeds a torn operation is repeated with. A failure names the one that caused it.
const SEEDS: std::ops::Range<u64> = 1..9;

fn open(flash: &mut SmallNor) -> Result<(Store<&mut SmallNor>, Opened), Error> {
    block_on(Store::open(flash, 0..LEN as u32))
}

fn contents(flash: &mut SmallNor) -> (Contents, Opened) {
    let (mut store, opened) = open(flash).unwrap();
    let mut found = Contents::new();
    block_on(store.load_all(|record| {
        found.insert(record.key, record.value);
    }))
    .unwrap();
    (found, opened)
}

/// One thing an owner of parameters does.
#[derive(Clone, Debug)]
enum Step {
    Store(Record),
    StoreAll(Vec<Record>),
    EraseAll,
}

/// Keys from here on belong to the set.
const SET_KEYS: u32 = 100;

impl Step {
    fn run(&self, store: &mut Store<&mut SmallNor>) -> Result<(), Error> {
        match self {
            Self::Store(record) => block_on(store.store(record)).map(drop),
            Self::StoreAll(records) => block_on(store.store_all(records.iter().copied())).map(drop),
            Self::EraseAll => block_on(store.erase_all()),
        }
    }

    fn apply(&self, model: &Contents) -> Contents {
        let mut after = model.clone();
        match self {
            Self::Store(record) => {
                after.insert(record.key, record.value);
            }
            Self::StoreAll(records) => {
                after.retain(|&key, _| key < SET_KEYS);
                after.extend(records.iter().map(|record| (record.key, record.value)));
            }
            Self::EraseAll => after.clear(),
        }
        after
    }
}

fn number(key: u32, value: u32) -> Record {
    Record { key, value: Value::from(value) }
}

fn set(values: impl IntoIterator<Item = u32>) -> Vec<Record> {
    (SET_KEYS..).zip(values).map(|(key, value)| number(key, value)).collect()
}

fn filled() -> (SmallNor, Contents) {
    let mut flash = SmallNor::new(1);
    let mut model = Contents::new();
    let (mut store, opened) = open(&mut flash).unwrap();
    assert_eq!(opened, Opened::Blank);
    let steps = (0..4).map(|key| Step::Store(number(key, key)));
    for step in steps.chain([Step::StoreAll(set([7, 8]))]) {
        step.run(&mut store).unwrap();
        model = step.apply(&model);
    }
    (flash, model)
}

/// Runs `step` on `flash` with the supply cut at every operation, and again at every operation of
/// the recovery.
fn check_all_cuts(flash: &SmallNor, model: &Contents, step: &Step) {
    let after = step.apply(model);
    let judge = |flash: &mut SmallNor, place: &str| {
        let (found, opened) = contents(flash);
        assert!(found == *model || found == after, "{place}: {found:?}");
        assert_ne!(opened, Opened::Lost, "{place}");
        let (mut store, _) = open(flash).unwrap();
        step.run(&mut store).unwrap_or_else(|e| panic!("{place}: afterwards {e:?}"));
        assert_eq!(contents(flash).0, after, "{place}: afterwards");
    };
    for seed in SEEDS {
        for cut in 0.. {
            let mut dying = flash.cut_at(cut, seed);
            let done = open(&mut dying).and_then(|(mut store, _)| step.run(&mut store));
            if !dying.is_unpowered() {
                assert_eq!(done, Ok(()), "seed {seed} cut {cut}");
                assert_eq!(contents(&mut dying).0, after, "seed {seed} cut {cut}");
                break;
            }
            for again in 0.. {
                let mut recovering = dying.cut_at(again, seed * 31 + u64::from(again));
                let recovered = open(&mut recovering).and_then(|(mut store, _)| {
                    let retried = step.run(&mut store);
                    block_on(store.load_all(|_| ())).and(retried)
                });
                let finished = !recovering.is_unpowered();
                judge(&mut recovering.powered(), &format!("seed {seed} cut {cut}, {again}"));
                if finished {
                    assert_eq!(recovered, Ok(()));
                    break;
                }
            }
        }
    }
}

/// NM17x STORE-02, STORE-07: a parameter is stored right after it was written. Every fill level of
/// the sectors is visited, so the cuts fall into recycling, too.
#[test]
fn a_power_cut_leaves_the_old_value_or_the_new_one() {
    let (mut flash, mut model) = filled();
    for round in 0..100 {
        let step = Step::Store(number(round % 4, 1_000 + round));
        check_all_cuts(&flash, &model, &step);
        step.run(&mut open(&mut flash).unwrap().0).unwrap();
        model = step.apply(&model);
    }
    assert!(flash.erases.iter().all(|&erases| erases > 0), "{:?}", flash.erases);
}

/// NM17x STORE-03, STORE-04: power loss while saving leaves the set saved before, or the new one.
#[test]
fn a_power_cut_leaves_the_old_set_or_the_new_one() {
    let (mut flash, mut model) = filled();
    for round in 0..12 {
        let step = Step::StoreAll(set((0..3 + round % 2).map(|item| round * 10 + item)));
        check_all_cuts(&flash, &model, &step);
        step.run(&mut open(&mut flash).unwrap().0).unwrap();
        model = step.apply(&model);
    }
}

/// NM17x STORE-05, STORE-06: defaults come back for all parameters or for none.
#[test]
fn a_power_cut_while_erasing_leaves_everything_or_nothing() {
    let (flash, model) = filled();
    check_all_cuts(&flash, &model, &Step::EraseAll);
}

/// NM17x STORE-09: a flash that fails once and goes on working loses nothing that was stored.
#[test]
fn a_failed_operation_loses_no_other_record() {
    let (mut flash, mut model) = filled();
    for round in 0..24 {
        let step = Step::Store(number(round % 4, 2_000 + round));
        let after = step.apply(&model);
        for seed in SEEDS {
            for at in 0.. {
                let mut failing = flash.glitch_at(at, seed);
                let (mut store, _) = match open(&mut failing) {
                    Ok(opened) => opened,
                    Err(_) => continue,
                };
                let first = step.run(&mut store);
                step.run(&mut store).unwrap_or_else(|e| panic!("seed {seed} at {at}: {e:?}"));
                let last = failing.operations <= at;
                assert_eq!(contents(&mut failing.powered()).0, after, "seed {seed} at {at}");
                if last {
                    assert_eq!(first, Ok(()));
                    break;
                }
            }
        }
        step.run(&mut open(&mut flash).unwrap().0).unwrap();
        model = after;
    }
}

fn any_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        any::<u32>().prop_map(Value::from),
        prop::collection::vec(any::<u8>(), 0..=storage::VALUE_LEN_MAX)
            .prop_map(|bytes| Value::from_bytes(&bytes).unwrap()),
    ]
}

fn any_step() -> impl Strategy<Value = Step> {
    prop_oneof![
        12 => (0..4_u32, any_value())
            .prop_map(|(key, value)| Step::Store(Record { key, value })),
        3 => prop::collection::vec(any::<u32>(), 0..5).prop_map(|values| Step::StoreAll(set(values))),
        1 => Just(Step::EraseAll),
    ]
}

proptest! {
    /// Any steps, each with the supply cut somewhere or not at all, against a plain map.
    #[test]
    fn any_history_matches_the_model(
        steps in prop::collection::vec((any_step(), prop::option::of((0..60_u32, any::<u64>()))), 1..60),
    ) {
        let mut flash = SmallNor::new(1);
        let mut model = Contents::new();
        for (step, cut) in steps {
            flash = match cut {
                Some((at, seed)) => flash.cut_at(at, seed),
                None => flash.powered(),
            };
            let done = open(&mut flash).and_then(|(mut store, _)| step.run(&mut store));
            let after = step.apply(&model);
            let interrupted = flash.is_unpowered();
            flash = flash.powered();
            let (found, opened) = contents(&mut flash);
            prop_assert_ne!(opened, Opened::Lost);
            if done.is_ok() {
                prop_assert_eq!(&found, &after);
            } else {
                prop_assert!(interrupted, "{:?}", done);
                prop_assert!(found == model || found == after, "{:?}", found);
            }
            model = found;
        }
    }
}

/// NM17x STORE-10, A-44: an equal value is not written again.
#[test]
fn an_equal_value_costs_no_flash_operation() {
    let (mut flash, _) = filled();
    flash = flash.powered();
    let (mut store, opened) = open(&mut flash).unwrap();
    assert_eq!(opened, Opened::Intact);
    assert_eq!(block_on(store.store(&number(2, 2))), Ok(Stored::Unchanged));
    assert_eq!(block_on(store.store_all(set([7, 8]))), Ok(Stored::Unchanged));
    assert_eq!(flash.operations, 0);
    let (mut store, _) = open(&mut flash).unwrap();
    assert_eq!(block_on(store.store(&number(2, 3))), Ok(Stored::Written));
    assert!(flash.operations > 0);
}
