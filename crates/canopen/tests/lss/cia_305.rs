use canopen::lss::{Event, Identity, Settings, Slave};

use crate::{IDENTITY, NM17X, ask, bytes, check, full, id, select};

fn slave() -> Slave {
    Slave::new(&Settings::CIA_305, IDENTITY, Some(id(5)))
}

/// CiA 305, switch state selective: the right identity only, from waiting only.
#[test]
fn a_selection_counts_in_waiting_only() {
    let mut device = slave();
    for wrong in [
        Identity { vendor_id: 0, ..IDENTITY },
        Identity { product_code: 0, ..IDENTITY },
        Identity { revision: 0, ..IDENTITY },
        Identity { serial: 0, ..IDENTITY },
    ] {
        assert_eq!(select(&mut device, &wrong), (None, None));
    }
    check(&mut device, &[("43 67 F5 52 4D", "-"), ("5E", "-")]);
    assert_eq!(select(&mut device, &IDENTITY).0, Some(full("44")));
    assert_eq!(select(&mut device, &Identity { serial: 0, ..IDENTITY }), (None, None));
    check(&mut device, &[("5E", "5E 05"), ("04 00", "-"), ("5E", "-")]);
}

/// CiA 305: every request has eight bytes.
#[test]
fn short_requests_change_nothing() {
    let mut device = slave();
    assert_eq!(ask(&mut device, &bytes("04 01")), (None, None));
    check(&mut device, &[("5E", "-"), ("04 01", "-"), ("5E", "5E 05")]);
    assert_eq!(ask(&mut device, &bytes("5E 00 00 00 00 00 00")), (None, None));
}

/// Decision A-24, and the eight bytes of CiA 305.
#[test]
fn a_request_has_the_length_the_product_asks_for() {
    let request = full("13 00 02");
    for (dlc, eight, as_needed) in
        [(0, false, false), (2, false, false), (3, false, true), (8, true, true)]
    {
        for (settings, answered) in [(&Settings::CIA_305, eight), (&NM17X, as_needed)] {
            let mut device = Slave::new(settings, IDENTITY, Some(id(5)));
            check(&mut device, &[("04 01", "-")]);
            let expected = answered.then(|| full("13 00"));
            assert_eq!(ask(&mut device, &request[..dlc]), (expected, None), "{dlc}");
        }
    }
}

#[test]
fn reserved_commands_and_arguments_are_no_requests() {
    let mut device = Slave::new(&Settings::CIA_305, IDENTITY, None);
    let reserved = [
        ("04 02", "-"),
        ("44", "-"),
        ("4F", "-"),
        ("51 EC 00 00 00 20 00 01", "-"),
        ("51 EC 00 00 00 1F 04 00", "-"),
        ("51 EC 00 00 00 1F 00 04", "-"),
        ("5F", "-"),
    ];
    check(&mut device, &reserved);
    check(&mut device, &[("51 EC 00 00 00 1F 00 00", "4F"), ("04 01", "-")]);
    check(&mut device, &reserved);
    check(&mut device, &[("5E", "5E FF")]);
}

/// CiA 305, identify remote slave: both ends of both ranges count, in their order.
#[test]
fn a_device_in_the_range_identifies_itself() {
    const VENDOR: &str = "46 EC 00 00 00";
    const PRODUCT: &str = "47 71 00 00 00";
    const REVISION_MIN: &str = "48 01 00 01 00";
    const REVISION_MAX: &str = "49 01 00 01 00";
    const SERIAL_MIN: &str = "4A 67 F5 52 4D";
    const SERIAL_MAX: &str = "4B 67 F5 52 4D";
    let right = [VENDOR, PRODUCT, REVISION_MIN, REVISION_MAX, SERIAL_MIN, SERIAL_MAX];
    let mut device = slave();
    let mut answers = |requests: [&str; 6]| {
        requests.map(|request| ask(&mut device, &full(request)).0).into_iter().flatten().last()
    };
    assert_eq!(answers(right), Some(full("4F")));
    for (place, wrong) in [
        (0, "46 ED 00 00 00"),
        (1, "47 72 00 00 00"),
        (2, "48 02 00 01 00"),
        (3, "49 00 00 01 00"),
        (4, "4A 68 F5 52 4D"),
        (5, "4B 66 F5 52 4D"),
        (3, SERIAL_MIN),
    ] {
        let mut requests = right;
        requests[place] = wrong;
        assert_eq!(answers(requests), None, "{wrong}");
    }
    assert_eq!(answers(right), Some(full("4F")));
}

/// CiA 305: a device without a node-ID says so, and starts with the one it is given.
#[test]
fn a_device_without_a_node_id_starts_when_it_has_one() {
    let mut device = Slave::new(&Settings::CIA_305, IDENTITY, None);
    check(&mut device, &[("4C", "50"), ("04 01", "-"), ("5E", "5E FF"), ("11 2A", "11 00")]);
    check(&mut device, &[("4C", "-"), ("5E", "5E FF")]);
    let configured = Some(Event::Configured { node_id: id(0x2A) });
    assert_eq!(ask(&mut device, &full("04 00")), (None, configured));
    check(&mut device, &[("04 01", "-"), ("5E", "5E 2A")]);
    assert_eq!(ask(&mut device, &full("04 00")), (None, None), "once");
}

/// CiA 305: node-ID 255 takes the node-ID away with the next reset of the communication.
#[test]
fn a_node_id_can_be_taken_away() {
    let mut device = slave();
    check(&mut device, &[("04 01", "-"), ("11 FF", "11 00"), ("5E", "5E 05")]);
    assert_eq!(device.pending_node_id(), None);
    let event = Some(Event::Store { node_id: None, bit_rate: None });
    assert_eq!(ask(&mut device, &full("17")).1, event);
}

/// CiA 305 without the vendor's extension: open parts of an identity are just wrong.
#[test]
fn open_parts_select_nobody() {
    let mut device = slave();
    let every =
        Identity { product_code: u32::MAX, revision: u32::MAX, serial: u32::MAX, ..IDENTITY };
    assert_eq!(select(&mut device, &every), (None, None));
    check(&mut device, &[("11 02", "-"), ("5E", "-")]);
}
