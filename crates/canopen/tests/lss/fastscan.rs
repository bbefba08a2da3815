use canopen::lss::{Identity, Settings, Slave};
use proptest::prelude::*;

use crate::{IDENTITY, ask, bytes, full, id};

fn unconfigured(identity: Identity) -> Slave {
    Slave::new(&Settings::CIA_305, identity, None)
}

/// Whether any device answers the question.
fn answered(devices: &mut [Slave], number: u32, bit_check: u8, sub: u8, next: u8) -> bool {
    let [a, b, c, d] = number.to_le_bytes();
    let question = [0x51, a, b, c, d, bit_check, sub, next];
    let answers = devices.iter_mut().filter_map(|device| ask(device, &question).0);
    answers.fold(false, |_, answer| answer == full("4F"))
}

/// A master's search, one bit after the other (CiA 305, fastscan).
fn scan(devices: &mut [Slave]) -> Option<Identity> {
    if !answered(devices, 0, 0x80, 0, 0) {
        return None;
    }
    let numbers = [0_u8, 1, 2, 3].map(|sub| {
        let mut number = 0;
        for bit in (0..32_u8).rev() {
            if !answered(devices, number, bit, sub, sub) {
                number |= 1 << bit;
            }
        }
        assert!(answered(devices, number, 0, sub, (sub + 1) % 4), "part {sub}");
        number
    });
    let [vendor_id, product_code, revision, serial] = numbers;
    Some(Identity { vendor_id, product_code, revision, serial })
}

fn identity() -> impl Strategy<Value = Identity> {
    any::<(u32, u32, u32, u32)>().prop_map(|(vendor_id, product_code, revision, serial)| Identity {
        vendor_id,
        product_code,
        revision,
        serial,
    })
}

proptest! {
    /// CiA 305, fastscan: one search finds one device and leaves it alone in configuration; with
    /// its node-ID it takes no part in the next.
    #[test]
    fn every_device_is_found_one_after_the_other(
        mut identities in prop::collection::vec(identity(), 1..5),
    ) {
        identities.sort_by_key(|i| (i.vendor_id, i.product_code, i.revision, i.serial));
        identities.dedup();
        let mut devices: Vec<_> = identities.iter().copied().map(unconfigured).collect();
        for node_id in 1..=identities.len() as u8 {
            let found = scan(&mut devices).unwrap();
            prop_assert!(identities.contains(&found));
            identities.retain(|identity| *identity != found);
            let taken = devices.iter_mut().filter_map(|device| ask(device, &full("5D")).0);
            let [a, b, c, d] = found.serial.to_le_bytes();
            prop_assert_eq!(taken.collect::<Vec<_>>(), [vec![0x5D, a, b, c, d, 0, 0, 0]]);
            for device in &mut devices {
                let _ = ask(device, &[0x11, node_id, 0, 0, 0, 0, 0, 0]);
                let _ = ask(device, &full("04 00"));
            }
        }
        prop_assert_eq!(scan(&mut devices), None);
    }
}

/// CiA 305: only devices without a node-ID, in waiting, take part; each in step with the scan.
#[test]
fn devices_with_a_node_id_or_in_configuration_take_no_part() {
    let mut configured = Slave::new(&Settings::CIA_305, IDENTITY, Some(id(1)));
    assert_eq!(ask(&mut configured, &bytes("51 00 00 00 00 80 00 00")), (None, None));
    let mut device = unconfigured(IDENTITY);
    let mut asked = |question: &str| ask(&mut device, &full(question)).0.is_some();
    assert!(asked("51 00 00 00 00 80 00 00"));
    assert!(!asked("51 71 00 00 00 00 01 02"), "the vendor comes first");
    assert!(asked("51 00 00 00 00 1F 00 00"), "only bit 31 counts");
    assert!(!asked("51 ED 00 00 00 00 00 01"));
    assert!(asked("51 EC 00 00 00 00 00 01"));
    assert!(!asked("04 01"));
    assert!(!asked("51 00 00 00 00 80 00 00"), "in configuration");
}
