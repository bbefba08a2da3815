use canopen::{AbortCode, AbortCodes, Expedited, Node, NodeId, Settings};
use expect_test::expect;
use object_dictionary::Object;

use crate::script::transcript;

const NAME: Object<[u8; 4]> = Object::new(0x1008, 0, "Name").default_text("AP04");
const PERIOD: Object<u16> = Object::new(0x1017, 0, "Heartbeat time").read_write();
const IN_PRE_OPERATIONAL: Object<u16> =
    Object::new(0x2000, 0, "Period").read_write().written_in_pre_operational();
const COMMAND: Object<u8> =
    Object::new(0x2001, 0, "Command").write_only().written_in_pre_operational();
const TARGET: Object<i32> = Object::new(0x5F16, 0, "Target").read_write().not_written_with_sdo();
const STATUS: Object<u8> = Object::new(0x5F19, 0, "Status").not_written_with_sdo();
const OFFSET: Object<i16> = Object::new(0x6000, 0, "Offset").read_write().within(-100, 100);
const FLAG: Object<u8> = Object::new(0x6001, 0, "Flag").read_write();

object_dictionary::product! {
    NAME, PERIOD, IN_PRE_OPERATIONAL, COMMAND, TARGET, STATUS, OFFSET, FLAG
}

/// AP04 A-35.
static FOUR_ONLY: Settings = Settings { expedited: Expedited::FourOnly, ..Settings::CIA_301 };

/// Encoder B-11.
static LONGER_TOO: Settings = Settings {
    expedited: Expedited::LongerToo,
    abort_codes: AbortCodes {
        number_length: AbortCode::UNSUPPORTED_ACCESS,
        ..Settings::CIA_301.abort_codes
    },
    ..Settings::CIA_301
};

fn happens(settings: &'static Settings, script: &str) -> String {
    let node: Node<LEN> = Node::new(&DICTIONARY, NodeId::new(5).unwrap(), settings);
    transcript(node, &mut (), script)
}

/// AP04 AP-SDO-06, AP-SDO-07: what is written in Pre-operational alone, and not with SDO at all.
/// The state is looked at before length and value, and again when the last segment comes.
#[test]
fn a_write_needs_the_state_that_the_entry_names() {
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 2B 00 20 00 05 00 00 00
        0001 > 585 [8] 60 00 20 00 00 00 00 00
        0002 < 605 [8] 2F 01 20 00 01 00 00 00
        0002 > 585 [8] 60 01 20 00 00 00 00 00
        0003 < 605 [8] 23 16 5F 00 01 00 00 00
        0003 > 585 [8] 80 16 5F 00 00 00 01 06
        0004 < 605 [8] 2F 19 5F 00 01 00 00 00
        0004 > 585 [8] 80 19 5F 00 00 00 01 06
        0005 < 605 [8] 40 19 5F 00 00 00 00 00
        0005 > 585 [8] 4F 19 5F 00 00 00 00 00
        0010 < 000 [2] 01 05
        0010 * PreOperational to Operational
        0011 < 605 [8] 2B 00 20 00 06 00 00 00
        0011 > 585 [8] 80 00 20 00 22 00 00 08
        0012 < 605 [8] 23 00 20 00 06 00 00 00
        0012 > 585 [8] 80 00 20 00 22 00 00 08
        0013 < 605 [8] 2F 01 20 00 01 00 00 00
        0013 > 585 [8] 80 01 20 00 22 00 00 08
        0014 < 605 [8] 21 00 20 00 02 00 00 00
        0014 > 585 [8] 80 00 20 00 22 00 00 08
        0015 < 605 [8] 40 00 20 00 00 00 00 00
        0015 > 585 [8] 4B 00 20 00 05 00 00 00
        0016 < 605 [8] 2F 01 60 00 01 00 00 00
        0016 > 585 [8] 60 01 60 00 00 00 00 00
        0020 < 000 [2] 80 05
        0020 * Operational to PreOperational
        0021 < 605 [8] 21 00 20 00 02 00 00 00
        0021 > 585 [8] 60 00 20 00 00 00 00 00
        0022 < 000 [2] 01 05
        0022 * PreOperational to Operational
        0023 < 605 [8] 0B 07 00 00 00 00 00 00
        0023 > 585 [8] 80 00 20 00 22 00 00 08
        0024 < 605 [8] 40 00 20 00 00 00 00 00
        0024 > 585 [8] 4B 00 20 00 05 00 00 00
    "#]]
    .assert_eq(&happens(
        &Settings::CIA_301,
        "
        0 boot
        1 < 605 2B 00 20 00 05 00 00 00
        2 < 605 2F 01 20 00 01 00 00 00
        3 < 605 23 16 5F 00 01 00 00 00
        4 < 605 2F 19 5F 00 01 00 00 00
        5 < 605 40 19 5F 00 00 00 00 00
        10 < 000 01 05
        11 < 605 2B 00 20 00 06 00 00 00
        12 < 605 23 00 20 00 06 00 00 00
        13 < 605 2F 01 20 00 01 00 00 00
        14 < 605 21 00 20 00 02 00 00 00
        15 < 605 40 00 20 00 00 00 00 00
        16 < 605 2F 01 60 00 01 00 00 00
        20 < 000 80 05
        21 < 605 21 00 20 00 02 00 00 00
        22 < 000 01 05
        23 < 605 0B 07 00 00 00 00 00 00
        24 < 605 40 00 20 00 00 00 00 00
        ",
    ));
}

/// AP04 AP-SDO-02, AP-SDO-03: every transfer has four bytes.
#[test]
fn a_product_may_have_transfers_of_four_bytes_only() {
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 40 08 10 00 00 00 00 00
        0001 > 585 [8] 42 08 10 00 41 50 30 34
        0002 < 605 [8] 23 00 60 00 9C FF FF FF
        0002 > 585 [8] 60 00 60 00 00 00 00 00
        0003 < 605 [8] 40 00 60 00 00 00 00 00
        0003 > 585 [8] 42 00 60 00 9C FF FF FF
        0004 < 605 [8] 23 01 60 00 FE 00 00 00
        0004 > 585 [8] 60 01 60 00 00 00 00 00
        0005 < 605 [8] 40 01 60 00 00 00 00 00
        0005 > 585 [8] 42 01 60 00 FE 00 00 00
        0006 < 605 [8] 23 01 60 00 00 01 00 00
        0006 > 585 [8] 80 01 60 00 31 00 09 06
        0007 < 605 [8] 23 00 60 00 9C FF 00 00
        0007 > 585 [8] 80 00 60 00 31 00 09 06
        0008 < 605 [8] 23 00 60 00 9B FF FF FF
        0008 > 585 [8] 80 00 60 00 32 00 09 06
        0009 < 605 [8] 2F 01 60 00 01 00 00 00
        0009 > 585 [8] 80 01 60 00 10 00 07 06
        0010 < 605 [8] 2B 00 60 00 01 00 00 00
        0010 > 585 [8] 80 00 60 00 10 00 07 06
        0011 < 605 [8] 27 00 60 00 01 00 00 00
        0011 > 585 [8] 80 00 60 00 10 00 07 06
        0012 < 605 [8] 22 00 60 00 01 00 00 00
        0012 > 585 [8] 80 00 60 00 10 00 07 06
        0013 < 605 [8] 20 00 60 00 00 00 00 00
        0013 > 585 [8] 80 00 60 00 01 00 04 05
        0014 < 605 [8] 21 00 60 00 02 00 00 00
        0014 > 585 [8] 80 00 60 00 01 00 04 05
        0015 < 605 [8] 60 00 00 00 00 00 00 00
        0015 > 585 [8] 80 00 00 00 01 00 04 05
        0016 < 605 [8] A0 08 10 00 7F 00 00 00
        0016 > 585 [8] 80 08 10 00 01 00 04 05
    "#]]
    .assert_eq(&happens(
        &FOUR_ONLY,
        "
        0 boot
        1 < 605 40 08 10 00 00 00 00 00
        2 < 605 23 00 60 00 9C FF FF FF
        3 < 605 40 00 60 00 00 00 00 00
        4 < 605 23 01 60 00 FE 00 00 00
        5 < 605 40 01 60 00 00 00 00 00
        6 < 605 23 01 60 00 00 01 00 00
        7 < 605 23 00 60 00 9C FF 00 00
        8 < 605 23 00 60 00 9B FF FF FF
        9 < 605 2F 01 60 00 01 00 00 00
        10 < 605 2B 00 60 00 01 00 00 00
        11 < 605 27 00 60 00 01 00 00 00
        12 < 605 22 00 60 00 01 00 00 00
        13 < 605 20 00 60 00 00 00 00 00
        14 < 605 21 00 60 00 02 00 00 00
        15 < 605 60 00 00 00 00 00 00 00
        16 < 605 A0 08 10 00 7F 00 00 00
        ",
    ));
}

/// Encoder EN-SDO-03, EN-SDO-05: bytes behind the entry's own do not count, missing ones do.
#[test]
fn a_product_may_take_more_bytes_than_it_needs() {
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 23 17 10 00 10 27 AA 55
        0001 > 585 [8] 60 17 10 00 00 00 00 00
        0001 > 705 [1] 7F
        0002 < 605 [8] 40 17 10 00 00 00 00 00
        0002 > 585 [8] 4B 17 10 00 10 27 00 00
        0003 < 605 [8] 27 01 60 00 07 AA 55 00
        0003 > 585 [8] 60 01 60 00 00 00 00 00
        0004 < 605 [8] 40 01 60 00 00 00 00 00
        0004 > 585 [8] 4F 01 60 00 07 00 00 00
        0005 < 605 [8] 22 00 60 00 05 00 AA 55
        0005 > 585 [8] 60 00 60 00 00 00 00 00
        0006 < 605 [8] 40 00 60 00 00 00 00 00
        0006 > 585 [8] 4B 00 60 00 05 00 00 00
        0007 < 605 [8] 2F 17 10 00 01 00 00 00
        0007 > 585 [8] 80 17 10 00 00 00 01 06
        0008 < 605 [8] 2B 00 60 00 65 00 00 00
        0008 > 585 [8] 80 00 60 00 31 00 09 06
    "#]]
    .assert_eq(&happens(
        &LONGER_TOO,
        "
        0 boot
        1 < 605 23 17 10 00 10 27 AA 55
        2 < 605 40 17 10 00 00 00 00 00
        3 < 605 27 01 60 00 07 AA 55 00
        4 < 605 40 01 60 00 00 00 00 00
        5 < 605 22 00 60 00 05 00 AA 55
        6 < 605 40 00 60 00 00 00 00 00
        7 < 605 2F 17 10 00 01 00 00 00
        8 < 605 2B 00 60 00 65 00 00 00
        ",
    ));
}
