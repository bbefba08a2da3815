//! The cases of a conformance test tool (CiA 310), as intents, on whole devices.
//!
//! `docs/conformance.md` has the outcome of each case on each device and is compared with what
//! happens here; `UPDATE_EXPECT=1` writes it anew. A case that a device can not be asked, because
//! it lacks what the case is about, says what it lacks. A case that fails, fails here.
#![expect(clippy::indexing_slicing, reason = "what an answer lacks fails the test")]

mod dictionary;
mod emergency;
mod error_control;
mod master;
mod pdo;
mod reference;
mod sdo;
mod states;
mod store;
mod sync;
mod whole;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};

use expect_test::expect_file;

use crate::master::{Device, Expedited, Master, Reason, Verdict, object};

/// One case.
pub(crate) struct Case {
    number: &'static str,
    intent: &'static str,
    /// Of CiA 301.
    clause: &'static str,
    run: fn(&mut Master) -> Verdict,
}

const CHAPTERS: &[(&str, &[Case])] = &[
    ("SDO", sdo::CASES),
    ("PDO", pdo::CASES),
    ("Object dictionary", dictionary::CASES),
    ("Emergency messages", emergency::CASES),
    ("SYNC", sync::CASES),
    ("Error control", error_control::CASES),
    ("Store, restore, identifiers", store::CASES),
    ("States and transitions", states::CASES),
];

const NM172: Device = Device {
    product: "nm172",
    engine: "twin",
    node_id: 127,
    dictionary: &profiles::nm172::DICTIONARY,
    expedited: Expedited::Indicated,
    // Writes wait for the link, which takes one each 10 ms (NM17x LINK-05).
    pause_ms: 11,
    commands: &[0x2015, 0x6003],
    stored: Some((object(0x1017, 0), 777)),
    remote: Ok(&[]),
    follows_changes: Ok(255),
    output: None,
    deviations: &[
        ("2.8", "the manual, section 4.3.3.4, has this code for a wrong length"),
        ("2.9", "the manual, section 4.3.3.4, has this code for a wrong length"),
    ],
};

const NM170: Device = Device {
    product: "nm170",
    dictionary: &profiles::nm170::DICTIONARY,
    deviations: &[
        ("2.8", "the manual, section 4.3.3.4, has this code for a wrong length"),
        ("2.9", "the manual, section 4.3.3.4, has this code for a wrong length"),
        ("3.21", "the manual, object 0x1A00, has the mapping of the types with a motor"),
    ],
    ..NM172
};

const NM174: Device =
    Device { product: "nm174", dictionary: &profiles::nm174::DICTIONARY, ..NM172 };

const AP04: Device = Device {
    product: "ap04",
    engine: "twin",
    node_id: 1,
    dictionary: &profiles::ap04::DICTIONARY,
    expedited: Expedited::FourBytes,
    pause_ms: 0,
    commands: &[0x2002, 0x5F15, 0x6001, 0x6003],
    stored: None,
    remote: Ok(&[(2, 253)]),
    follows_changes: Err("PDOs follow the event timer or the SYNC alone"),
    output: None,
    deviations: &[
        ("2.8", "values are always written as four bytes (manual, section 5, SDO)"),
        ("2.9", "values are always written as four bytes (manual, section 5, SDO)"),
        ("3.6", "the manual, object 0x1801:02, has types 1 to 240 answer each SYNC"),
        ("6.3", "the manual, object 0x1801:02, has types 1 to 240 answer each SYNC"),
        ("8.4", "every value is stored at once, and restored so"),
        ("8.10", "the manual's range of identifiers is 0x001 to 0x7FF"),
    ],
};

const GXMM: Device = Device {
    product: "gxmm",
    engine: "twin",
    node_id: 1,
    dictionary: &profiles::encoder::gxmm::DICTIONARY,
    expedited: Expedited::Indicated,
    pause_ms: 0,
    commands: &[0x6003],
    stored: Some((object(0x1017, 0), 777)),
    remote: Err("PDOs follow the event timer or the SYNC alone"),
    follows_changes: Err("PDOs follow the event timer or the SYNC alone"),
    output: None,
    deviations: &[
        ("2.8", "bytes beyond the object are ignored (manual, section 6.2)"),
        ("2.9", "the manual, section 4.3.3, has this code for a wrong access"),
        ("8.4", "the manual, object 0x1011, restores the working memory"),
        ("8.8", "the manual, object 0x1011, restores the working memory"),
        ("8.10", "the manual's range of identifiers is 0x001 to 0x7FF"),
    ],
};

/// With everything the stack has, and no manual of its own.
const DEV1: Device = Device {
    product: "DEV1",
    engine: "process",
    node_id: dev1::NODE_ID.get(),
    dictionary: &dev1::DICTIONARY,
    expedited: Expedited::Indicated,
    pause_ms: 0,
    commands: &[],
    stored: Some((object(0x1017, 0), 777)),
    remote: Ok(&[]),
    follows_changes: Ok(255),
    output: Some(object(0x6200, 1)),
    deviations: &[],
};

/// What DEV1 lacks.
const WHOLE: Device = Device {
    product: "whole",
    dictionary: &whole::DICTIONARY,
    output: Some(object(0x6200, 2)),
    ..DEV1
};

/// The devices of the table, in the order of its columns.
const DEVICES: &[Device] = &[DEV1, WHOLE, NM170, NM172, NM174, AP04, GXMM];

/// The outcome of every case of the chapters on a device, by number.
fn judged(device: Device, chapters: &[(&str, &[Case])]) -> BTreeMap<&'static str, Verdict> {
    let mut master = Master::new(device);
    let mut verdicts = BTreeMap::new();
    let mut failures = String::new();
    for (chapter, cases) in chapters {
        for case in *cases {
            let judge = AssertUnwindSafe(|| (case.run)(&mut master));
            let verdict = match catch_unwind(judge) {
                Ok(Err(Reason::Deviates(what))) if justification(device, case).is_none() => {
                    Err(what)
                }
                Ok(verdict) => Ok(verdict),
                Err(panic) => Err(sentence(&*panic)),
            };
            match verdict {
                Ok(verdict) => {
                    verdicts.insert(case.number, verdict);
                }
                Err(what) => {
                    let Case { number, intent, .. } = case;
                    let _ = writeln!(failures, "{number}: {chapter}, {intent}: {what}");
                    master = Master::new(device);
                }
            }
        }
    }
    for (number, justification) in device.deviations {
        let deviates = |verdict: &Verdict| matches!(verdict, Err(Reason::Deviates(_)));
        if verdicts.get(number).is_some_and(|verdict| !deviates(verdict)) {
            let _ = writeln!(failures, "{number} does not deviate: {justification}");
        }
    }
    assert!(failures.is_empty(), "{} on the {}:\n{failures}", device.product, device.engine);
    verdicts
}

fn justification(device: Device, case: &Case) -> Option<&'static str> {
    let of_case = device.deviations.iter().find(|(number, _)| *number == case.number);
    of_case.map(|(_, justification)| *justification)
}

/// What a test panicked with.
fn sentence(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or_default().to_owned()
}

/// One line for each case, one column for each device, and below the reasons why a case is not
/// passed.
#[test]
fn every_case_on_every_device() {
    let verdicts: Vec<_> = DEVICES.iter().map(|&device| judged(device, CHAPTERS)).collect();
    let mut page = HEAD.to_owned();
    let mut reasons: Vec<String> = Vec::new();
    for (chapter, cases) in CHAPTERS {
        let names: Vec<_> = DEVICES.iter().map(|device| device.product).collect();
        let _ =
            writeln!(page, "\n## {chapter}\n\n| case | what | CiA 301 | {} |", names.join(" | "));
        let _ = writeln!(page, "|---|---|---|{}", "---|".repeat(names.len()));
        for case in *cases {
            let cells = DEVICES.iter().zip(&verdicts).map(|(&device, verdicts)| {
                let reason = match &verdicts[case.number] {
                    Ok(()) => return "passed".to_owned(),
                    Err(Reason::Lacks(what)) => what.clone(),
                    Err(Reason::Deviates(what)) => {
                        format!("{what}: {}", justification(device, case).unwrap_or_default())
                    }
                };
                let known = reasons.iter().position(|known| *known == reason);
                let place = known.unwrap_or(reasons.len());
                if known.is_none() {
                    reasons.push(reason);
                }
                format!("({})", place + 1)
            });
            let cells: Vec<_> = cells.collect();
            let Case { number, intent, clause, .. } = case;
            let _ = writeln!(page, "| {number} | {intent} | {clause} | {} |", cells.join(" | "));
        }
    }
    page.push_str("\n## Why a case is not passed\n\n");
    for (number, reason) in (1..).zip(&reasons) {
        let _ = writeln!(page, "{number}. {reason}");
    }
    expect_file!["../../../docs/conformance.md"].assert_eq(&page);
}

const HEAD: &str = "\
# Conformance

The cases of the CiA 301 conformance test, tried on whole devices on the bench by
`tests-host/tests/conformance`, which also writes this page. A number in brackets is a reason below:
the device lacks what the case is about, or its manual asks for something else. The encoder gxmm stands
for all encoders, which differ from it in numbers alone.

DEV1 is the device that [stacks are compared with](benchmarks.md); *whole* has what DEV1 lacks. Both are
the stack with a memory, and no products.

The cases of the SDO server and of the states have the same outcome on the images of nm172 and DEV1.

Case 1.0, the data sheet: `dcfchk` and python-canopen accept every file in `eds/`
(`tests-host/python/test_eds.py`).
";

/// The server and the states of the images as they are flashed: a product, and DEV1 for what the
/// product does without, block transfer above all.
#[test]
fn cases_on_the_images() {
    // Its image has no memory.
    let dev1 = Device { product: "dev1", stored: None, ..DEV1 };
    for device in [NM172, dev1] {
        let image = Device { engine: "image", ..device };
        let chapters = [("SDO", sdo::CASES), ("States and transitions", states::CASES)];
        let verdicts = judged(device, &chapters);
        assert_eq!(judged(image, &chapters), verdicts, "{} as an image", device.product);
    }
}
