use canopen::{Node, NodeId, Settings};
use expect_test::expect;
use object_dictionary::Object;

use crate::script::transcript;

const DEVICE_TYPE: Object<u32> = Object::new(0x1000, 0, "Device type");
const STORE: Object<u8> = Object::highest_sub_index(0x1010, "Store parameters", 2);
const STORE_ALL: Object<u32> = Object::new(0x1010, 1, "Store").read_write().default(1);
const STORE_ITSELF: Object<u32> = Object::new(0x1010, 2, "Store").default(2);
const RESTORE: Object<u8> = Object::highest_sub_index(0x1011, "Restore parameters", 1);
const RESTORE_ALL: Object<u32> = Object::new(0x1011, 1, "Restore").read_write().default(1);

object_dictionary::product! { DEVICE_TYPE, STORE, STORE_ALL, STORE_ITSELF, RESTORE, RESTORE_ALL }

fn happens(script: &str) -> String {
    let node_id = NodeId::new(5).unwrap();
    let node: Node<LEN> = Node::new(&DICTIONARY, node_id, &Settings::CIA_301);
    transcript(node, &mut (), script)
}

/// NM17x STORE-04, STORE-05, AP04 AP-STO-03, encoder EN-STO-01: only the signature counts, and only
/// where the entry takes it.
#[test]
fn the_answer_follows_the_storage() {
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 23 10 10 01 73 61 76 65
        0001 * Store { sub: 1 }
        0020 > 585 [8] 60 10 10 01 00 00 00 00
        0030 < 605 [8] 23 10 10 01 73 61 76 65
        0030 * Store { sub: 1 }
        0040 > 585 [8] 80 10 10 01 00 00 06 06
        0050 < 605 [8] 23 11 10 01 6C 6F 61 64
        0050 * Restore { sub: 1 }
        0060 > 585 [8] 60 11 10 01 00 00 00 00
        0061 < 605 [8] 23 10 10 01 6C 6F 61 64
        0061 > 585 [8] 80 10 10 01 20 00 00 08
        0062 < 605 [8] 23 11 10 01 73 61 76 65
        0062 > 585 [8] 80 11 10 01 20 00 00 08
        0063 < 605 [8] 23 10 10 02 73 61 76 65
        0063 > 585 [8] 80 10 10 02 02 00 01 06
        0064 < 605 [8] 2B 10 10 01 73 61 00 00
        0064 > 585 [8] 80 10 10 01 10 00 07 06
        0065 < 605 [8] 40 10 10 01 00 00 00 00
        0065 > 585 [8] 43 10 10 01 01 00 00 00
        0070 < 605 [8] 21 10 10 01 04 00 00 00
        0070 > 585 [8] 60 10 10 01 00 00 00 00
        0071 < 605 [8] 07 73 61 76 65 00 00 00
        0071 * Store { sub: 1 }
        0080 > 585 [8] 20 00 00 00 00 00 00 00
    "#]]
    .assert_eq(&happens(
        "
        0 boot
        1 < 605 23 10 10 01 73 61 76 65
        20 stored
        30 < 605 23 10 10 01 73 61 76 65
        40 not stored
        50 < 605 23 11 10 01 6C 6F 61 64
        60 stored
        61 < 605 23 10 10 01 6C 6F 61 64
        62 < 605 23 11 10 01 73 61 76 65
        63 < 605 23 10 10 02 73 61 76 65
        64 < 605 2B 10 10 01 73 61 00 00
        65 < 605 40 10 10 01 00 00 00 00
        70 < 605 21 10 10 01 04 00 00 00
        71 < 605 07 73 61 76 65 00 00 00
        80 stored
        81 stored
        ",
    ));
}

/// CiA 301, section 7.2.4.2: a client that goes on, gives up or is stopped gets no late answer, and
/// the storage does one thing at a time.
#[test]
fn nobody_gets_an_answer_that_is_not_waited_for() {
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 23 10 10 01 73 61 76 65
        0001 * Store { sub: 1 }
        0002 < 605 [8] 40 00 10 00 00 00 00 00
        0002 > 585 [8] 43 00 10 00 00 00 00 00
        0010 < 605 [8] 23 10 10 01 73 61 76 65
        0010 * Store { sub: 1 }
        0011 < 605 [8] 23 11 10 01 6C 6F 61 64
        0011 > 585 [8] 80 11 10 01 22 00 00 08
        0020 < 605 [8] 23 10 10 01 73 61 76 65
        0020 * Store { sub: 1 }
        0021 < 605 [8] 80 10 10 01 00 00 00 08
        0030 < 605 [8] 23 10 10 01 73 61 76 65
        0030 * Store { sub: 1 }
        0031 < 000 [2] 02 05
        0031 * PreOperational to Stopped
        0032 < 000 [2] 80 05
        0032 * Stopped to PreOperational
        0040 < 605 [8] 23 10 10 01 73 61 76 65
        0040 * Store { sub: 1 }
        5040 > 585 [8] 80 10 10 01 00 00 06 06
        6000 < 605 [8] 23 10 10 01 73 61 76 65
        6000 > 585 [8] 80 10 10 01 22 00 00 08
        6002 < 605 [8] 23 10 10 01 73 61 76 65
        6002 * Store { sub: 1 }
        6003 > 585 [8] 60 10 10 01 00 00 00 00
        7000 < 605 [8] 23 10 10 01 73 61 76 65
        7000 * Store { sub: 1 }
        7001 < 605 [8] 21 11 10 01 04 00 00 00
        7001 > 585 [8] 60 11 10 01 00 00 00 00
        7002 < 605 [8] 07 6C 6F 61 64 00 00 00
        7002 > 585 [8] 80 11 10 01 22 00 00 08
    "#]]
    .assert_eq(&happens(
        "
        0 boot
        1 < 605 23 10 10 01 73 61 76 65
        2 < 605 40 00 10 00 00 00 00 00
        3 stored
        10 < 605 23 10 10 01 73 61 76 65
        11 < 605 23 11 10 01 6C 6F 61 64
        12 stored
        20 < 605 23 10 10 01 73 61 76 65
        21 < 605 80 10 10 01 00 00 00 08
        22 not stored
        30 < 605 23 10 10 01 73 61 76 65
        31 < 000 02 05
        32 < 000 80 05
        33 stored
        40 < 605 23 10 10 01 73 61 76 65
        6000 < 605 23 10 10 01 73 61 76 65
        6001 stored
        6002 < 605 23 10 10 01 73 61 76 65
        6003 stored
        7000 < 605 23 10 10 01 73 61 76 65
        7001 < 605 21 11 10 01 04 00 00 00
        7002 < 605 07 6C 6F 61 64 00 00 00
        7003 stored
        ",
    ));
}
