use canopen::lss::{BitRate, Event, Identity, Slave, StoreError};
use units::Duration;

use crate::{IDENTITY, NM17X, apart, ask, bytes, check, full, id, select};

fn slave(serial: u32) -> Slave {
    Slave::new(&NM17X, Identity { serial, ..IDENTITY }, Some(id(0x7F)))
}

/// The steps of the manual's example, section 3.1.2: requests and the answer of the device meant.
const SELECTIVE: &[(&str, &str, Option<&str>)] = &[
    ("V-LSSADR-02", "04 01", None),
    ("V-LSSADR-03", "40 EC 00 00 00 00 00 00", None),
    ("V-LSSADR-04", "41 71 00 00 00 00 00 00", None),
    ("V-LSSADR-05", "42 01 00 01 00 00 00 00", None),
    ("V-LSSADR-06, 07", "43 67 F5 52 4D 00 00 00", Some("44 00 00 00 00 00 00 00")),
    ("V-LSSADR-08, 09", "11 25", Some("11 00 00 00 00 00 00 00")),
    ("V-LSSADR-10, 11", "17 00", Some("17 00 00 00 00 00 00 00")),
];

/// NM17x ADDR-03, ADDR-04, ADDR-05, ADDR-06; decisions.
#[test]
fn of_several_devices_the_one_selected_takes_the_node_id() {
    let (mut meant, mut other) = (slave(IDENTITY.serial), slave(1));
    for (name, request, answer) in SELECTIVE {
        let (mut answered, event) = ask(&mut meant, &bytes(request));
        if let Some(Event::Store { node_id, bit_rate }) = event {
            assert_eq!((answered.take(), node_id, bit_rate), (None, Some(id(0x25)), None));
            (answered, _) = apart(meant.handle_stored(Ok(())));
        }
        assert_eq!(answered, answer.map(bytes), "{name}");
        assert_eq!(ask(&mut other, &bytes(request)), (None, None), "{name}");
    }
    assert_eq!(
        (meant.pending_node_id(), other.pending_node_id()),
        (Some(id(0x25)), Some(id(0x7F)))
    );
}

/// The steps of the manual's example, section 3.1.3, to the point where the devices wait for an
/// offer.
const ADDRESSING: &[(&str, &str)] = &[
    ("V-DEVADR-02", "04 01"),
    ("V-DEVADR-03", "40 EC 00 00 00 00 00 00"),
    ("V-DEVADR-04", "41 FF FF FF FF 00 00 00"),
    ("V-DEVADR-05", "42 FF FF FF FF 00 00 00"),
    ("V-DEVADR-06", "43 FF FF FF FF 00 00 00"),
];

/// V-DEVADR-08 and V-DEVADR-10.
const TAKEN: &str = "11 00 00 00 00 00 00 00";

/// NM17x ADDR-07, ADDR-08, ADDR-09, ADDR-10, LSS-10; decision A-49.
#[test]
fn the_device_that_is_touched_takes_the_offer() {
    let mut devices = [slave(1), slave(2), slave(3)];
    for (name, request) in ADDRESSING {
        for device in &mut devices {
            assert_eq!(ask(device, &bytes(request)), (None, None), "{name}");
        }
    }
    for (name, request, node_id, touched) in [
        ("V-DEVADR-07", "11 02 00 00 00 00 00 00", id(2), 1),
        ("V-DEVADR-09", "11 03 00 00 00 00 00 00", id(3), 0),
    ] {
        for device in &mut devices {
            let offered = Some(Event::Offered { node_id });
            assert_eq!(ask(device, &bytes(request)), (None, offered), "{name}");
        }
        let device = devices.get_mut(touched).unwrap();
        let taken = Some(Event::StoreNodeId { node_id });
        assert_eq!(apart(device.take_offer()), (None, taken));
        assert_eq!(apart(device.handle_stored(Ok(()))), (Some(bytes(TAKEN)), None));
        assert_eq!(device.take_offer(), None, "once per offer");
    }
    let pending = devices.each_ref().map(|device| device.pending_node_id().map(|id| id.get()));
    assert_eq!(pending, [Some(3), Some(2), Some(0x7F)]);
    for device in &mut devices {
        assert_eq!(ask(device, &bytes("04 00")), (None, Some(Event::AddressingEnded)));
        assert_eq!(device.take_offer(), None);
    }
}

/// NM17x ADDR-09: an offer that was not stored is not taken.
#[test]
fn an_offer_that_could_not_be_stored_stays_unanswered() {
    let mut device = slave(1);
    for (_, request) in ADDRESSING {
        let _ = ask(&mut device, &bytes(request));
    }
    let _ = ask(&mut device, &bytes("11 02"));
    let _ = device.take_offer();
    assert_eq!(device.handle_stored(Err(StoreError::AccessFailed)), None);
    assert_eq!(device.pending_node_id(), Some(id(0x7F)));
}

/// NM17x LSS-10: only the own vendor's devices follow, and only when all the rest is open.
#[test]
fn addressing_needs_the_vendor_and_nothing_else() {
    const EVERY: u32 = u32::MAX;
    for (vendor_id, product_code, expected) in
        [(0xEC, EVERY, true), (0xED, EVERY, false), (0xEC, 0x71, false), (EVERY, EVERY, false)]
    {
        let mut device = slave(1);
        let identity = Identity { vendor_id, product_code, revision: EVERY, serial: EVERY };
        assert_eq!(select(&mut device, &identity), (None, None));
        let offered = ask(&mut device, &bytes("11 02")).1;
        assert_eq!(offered.is_some(), expected, "{vendor_id:#X} {product_code:#X}");
    }
}

/// NM17x ADDR-08, LSS-09: nothing else has an effect while offers are shown.
#[test]
fn addressing_is_left_by_a_global_switch_only() {
    let mut device = slave(1);
    for (_, request) in ADDRESSING {
        let _ = ask(&mut device, &bytes(request));
    }
    check(&mut device, &[("11 00", "-"), ("11 80", "-"), ("13 00 02", "-"), ("5E", "-")]);
    assert_eq!(select(&mut device, &Identity { serial: 1, ..IDENTITY }), (None, None));
    assert!(ask(&mut device, &bytes("11 02")).1.is_some());
}

/// NM17x LSS-02 to LSS-09; decisions.
#[test]
fn every_service_answers_in_configuration_and_only_there() {
    const SERVICES: &[(&str, &str)] = &[
        ("11 01", "11 00"),
        ("11 7F", "11 00"),
        ("11 00", "11 01"),
        ("11 80", "11 01"),
        ("11 FF", "11 01"),
        ("13 00 00", "13 00"),
        ("13 00 08", "13 00"),
        ("13 00 09", "13 01"),
        ("13 01 00", "13 01"),
        ("13 80 00", "13 01"),
        ("13 00", "-"),
        ("5A", "5A EC 00 00 00"),
        ("5B", "5B 71 00 00 00"),
        ("5C", "5C 01 00 01 00"),
        ("5D", "5D 67 F5 52 4D"),
        ("5E", "5E 7F"),
        ("4C", "-"),
        ("51 00 00 00 00 80 00 00", "-"),
        ("5F", "-"),
        ("", "-"),
    ];
    let mut device = slave(IDENTITY.serial);
    for (request, _) in SERVICES {
        assert_eq!(ask(&mut device, &bytes(request)), (None, None), "{request} in waiting");
    }
    let _ = ask(&mut device, &bytes("04 01"));
    for (request, answer) in SERVICES {
        let expected = (*answer != "-").then(|| full(answer));
        assert_eq!(ask(&mut device, &bytes(request)), (expected, None), "{request}");
    }
    let _ = ask(&mut device, &bytes("04 00"));
    assert_eq!(ask(&mut device, &bytes("5E")), (None, None));
}

/// NM17x LSS-07; decision A-26: without a pending rate there is nothing to activate.
#[test]
fn a_bit_rate_is_activated_once_one_is_configured() {
    let mut device = slave(1);
    let _ = ask(&mut device, &bytes("04 01"));
    assert_eq!(ask(&mut device, &bytes("15 E8 03")), (None, None));
    check(&mut device, &[("13 00 02", "13 00"), ("13 00 09", "13 01")]);
    let (bit_rate, delay) = (BitRate::Kbit500, Duration::from_millis(1_000));
    let event = Some(Event::ActivateBitTiming { bit_rate, delay });
    assert_eq!(ask(&mut device, &bytes("15 E8 03")), (None, event));
}

/// NM17x LSS-06.
#[test]
fn a_store_is_answered_once_when_it_is_done() {
    for (outcome, answer) in [
        (Ok(()), "17 00"),
        (Err(StoreError::NotSupported), "17 01"),
        (Err(StoreError::AccessFailed), "17 02"),
    ] {
        let mut device = slave(1);
        let _ = ask(&mut device, &bytes("04 01"));
        let _ = ask(&mut device, &bytes("13 00 04"));
        let bit_rate = Some(BitRate::Kbit125);
        let event = Some(Event::Store { node_id: Some(id(0x7F)), bit_rate });
        assert_eq!(ask(&mut device, &bytes("17")), (None, event));
        assert_eq!(ask(&mut device, &bytes("17")), (None, None), "the first still waits");
        assert_eq!(apart(device.handle_stored(outcome)), (Some(full(answer)), None));
        assert_eq!(device.handle_stored(Ok(())), None);
    }
}

/// Decision A-23: a selection also ends the configuration of the one selected before.
#[test]
fn one_selection_after_the_other_needs_no_switch_between() {
    let (mut first, mut second) = (slave(1), slave(2));
    for (serial, node_id) in [(1, "11 05"), (2, "11 06")] {
        let identity = Identity { serial, ..IDENTITY };
        let answers = [&mut first, &mut second].map(|device| select(device, &identity).0);
        assert_eq!(answers.iter().flatten().count(), 1);
        let answers = [&mut first, &mut second].map(|device| ask(device, &bytes(node_id)).0);
        assert_eq!(answers.iter().flatten().count(), 1);
    }
    assert_eq!((first.pending_node_id(), second.pending_node_id()), (Some(id(5)), Some(id(6))));
}
