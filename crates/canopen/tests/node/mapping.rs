use canopen::{CanId, Frame, Node, Settings};
use expect_test::{Expect, expect};
use object_dictionary::ObjectId;
use proptest::collection::vec;
use proptest::prelude::*;
use units::Instant;

use crate::configurable::{DICTIONARY, LEN, node};
use crate::script::transcript;

#[track_caller]
fn check(script: &str, expected: Expect) {
    expected.assert_eq(&transcript(node(&Settings::CIA_301), &mut (), script));
}

/// Conformance cases 3.21 and 3.22; CiA 301, section 7.5.2.36: off, no entries, new entries, their
/// count, on.
#[test]
fn the_procedure_gives_a_pdo_another_mapping() {
    check(
        "
        0 set 6000:01 -2, 6000:02 3, 6000:03 67305985, 6200:02 -4
        0 boot
        1 < 000 01 00
        2 < 605 23 00 18 01 85 01 00 80
        3 < 605 2F 00 1A 00 00 00 00 00
        4 < 605 23 00 1A 01 08 02 00 60
        5 < 605 23 00 1A 02 20 03 00 60
        6 < 605 23 00 1A 03 10 02 00 62
        7 < 605 2F 00 1A 00 03 00 00 00
        8 < 605 23 00 18 01 85 01 00 00
        9 set 6000:01 7
        10 < 605 2B 00 62 02 05 00 00 00
        11 < 605 23 00 18 01 85 01 00 80
        12 < 605 2F 00 1A 00 02 00 00 00
        13 < 605 23 00 18 01 85 01 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0001 > 185 [3] FE FF 03
            0002 < 605 [8] 23 00 18 01 85 01 00 80
            0002 > 585 [8] 60 00 18 01 00 00 00 00
            0002 * FiltersChanged
            0003 < 605 [8] 2F 00 1A 00 00 00 00 00
            0003 > 585 [8] 60 00 1A 00 00 00 00 00
            0004 < 605 [8] 23 00 1A 01 08 02 00 60
            0004 > 585 [8] 60 00 1A 01 00 00 00 00
            0005 < 605 [8] 23 00 1A 02 20 03 00 60
            0005 > 585 [8] 60 00 1A 02 00 00 00 00
            0006 < 605 [8] 23 00 1A 03 10 02 00 62
            0006 > 585 [8] 60 00 1A 03 00 00 00 00
            0007 < 605 [8] 2F 00 1A 00 03 00 00 00
            0007 > 585 [8] 60 00 1A 00 00 00 00 00
            0008 < 605 [8] 23 00 18 01 85 01 00 00
            0008 > 585 [8] 60 00 18 01 00 00 00 00
            0008 * FiltersChanged
            0008 > 185 [7] 03 01 02 03 04 FC FF
            0010 < 605 [8] 2B 00 62 02 05 00 00 00
            0010 > 585 [8] 60 00 62 02 00 00 00 00
            0010 > 185 [7] 03 01 02 03 04 05 00
            0011 < 605 [8] 23 00 18 01 85 01 00 80
            0011 > 585 [8] 60 00 18 01 00 00 00 00
            0011 * FiltersChanged
            0012 < 605 [8] 2F 00 1A 00 02 00 00 00
            0012 > 585 [8] 60 00 1A 00 00 00 00 00
            0013 < 605 [8] 23 00 18 01 85 01 00 00
            0013 > 585 [8] 60 00 18 01 00 00 00 00
            0013 * FiltersChanged
            0013 > 185 [5] 03 01 02 03 04
        "#]],
    );
}

/// Conformance cases 3.23 and 3.24: entries stay while the PDO is on, or has a count.
#[test]
fn a_mapping_stays_without_the_procedure() {
    check(
        "
        0 boot
        1 < 605 23 00 1A 01 08 02 00 60
        2 < 605 2F 00 1A 00 01 00 00 00
        3 < 605 23 00 16 01 10 02 00 62
        4 < 605 2F 00 16 00 00 00 00 00
        5 < 605 23 00 18 01 85 01 00 80
        6 < 605 23 00 1A 01 08 02 00 60
        7 < 605 40 00 1A 01 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 00 1A 01 08 02 00 60
            0001 > 585 [8] 80 00 1A 01 00 00 01 06
            0002 < 605 [8] 2F 00 1A 00 01 00 00 00
            0002 > 585 [8] 80 00 1A 00 00 00 01 06
            0003 < 605 [8] 23 00 16 01 10 02 00 62
            0003 > 585 [8] 80 00 16 01 00 00 01 06
            0004 < 605 [8] 2F 00 16 00 00 00 00 00
            0004 > 585 [8] 80 00 16 00 00 00 01 06
            0005 < 605 [8] 23 00 18 01 85 01 00 80
            0005 > 585 [8] 60 00 18 01 00 00 00 00
            0005 * FiltersChanged
            0006 < 605 [8] 23 00 1A 01 08 02 00 60
            0006 > 585 [8] 80 00 1A 01 00 00 01 06
            0007 < 605 [8] 40 00 1A 01 00 00 00 00
            0007 > 585 [8] 43 00 1A 01 10 01 00 60
        "#]],
    );
}

/// Conformance cases 3.25 and 3.26: more than eight objects, or more than eight bytes. A count that
/// is refused leaves none.
#[test]
fn a_pdo_takes_eight_objects_and_eight_bytes() {
    check(
        "
        0 boot
        1 < 605 23 00 18 01 85 01 00 80
        2 < 605 2F 00 1A 00 09 00 00 00
        3 < 605 2F 00 1A 00 03 00 00 00
        4 < 605 2F 00 1A 00 00 00 00 00
        5 < 605 23 00 1A 01 20 03 00 60
        6 < 605 23 00 1A 02 20 03 00 60
        7 < 605 23 00 1A 03 08 02 00 60
        8 < 605 2F 00 1A 00 03 00 00 00
        9 < 605 40 00 1A 00 00 00 00 00
        10 < 605 2F 00 1A 00 02 00 00 00
        11 < 605 23 00 14 01 05 02 00 80
        12 < 605 2F 00 16 00 00 00 00 00
        13 < 605 23 00 16 02 10 02 00 62
        14 < 605 2F 00 16 00 05 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 00 18 01 85 01 00 80
            0001 > 585 [8] 60 00 18 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 605 [8] 2F 00 1A 00 09 00 00 00
            0002 > 585 [8] 80 00 1A 00 42 00 04 06
            0003 < 605 [8] 2F 00 1A 00 03 00 00 00
            0003 > 585 [8] 80 00 1A 00 00 00 02 06
            0004 < 605 [8] 2F 00 1A 00 00 00 00 00
            0004 > 585 [8] 60 00 1A 00 00 00 00 00
            0005 < 605 [8] 23 00 1A 01 20 03 00 60
            0005 > 585 [8] 60 00 1A 01 00 00 00 00
            0006 < 605 [8] 23 00 1A 02 20 03 00 60
            0006 > 585 [8] 60 00 1A 02 00 00 00 00
            0007 < 605 [8] 23 00 1A 03 08 02 00 60
            0007 > 585 [8] 60 00 1A 03 00 00 00 00
            0008 < 605 [8] 2F 00 1A 00 03 00 00 00
            0008 > 585 [8] 80 00 1A 00 42 00 04 06
            0009 < 605 [8] 40 00 1A 00 00 00 00 00
            0009 > 585 [8] 4F 00 1A 00 00 00 00 00
            0010 < 605 [8] 2F 00 1A 00 02 00 00 00
            0010 > 585 [8] 60 00 1A 00 00 00 00 00
            0011 < 605 [8] 23 00 14 01 05 02 00 80
            0011 > 585 [8] 60 00 14 01 00 00 00 00
            0011 * FiltersChanged
            0012 < 605 [8] 2F 00 16 00 00 00 00 00
            0012 > 585 [8] 60 00 16 00 00 00 00 00
            0013 < 605 [8] 23 00 16 02 10 02 00 62
            0013 > 585 [8] 60 00 16 02 00 00 00 00
            0014 < 605 [8] 2F 00 16 00 05 00 00 00
            0014 > 585 [8] 80 00 16 00 00 00 02 06
        "#]],
    );
}

/// Conformance cases 3.27 to 3.32: objects that are missing, not mappable, of the other direction,
/// texts, and objects with another length than their own.
#[test]
fn what_a_pdo_cannot_carry_is_refused() {
    check(
        "
        0 boot
        1 < 605 23 00 18 01 85 01 00 80
        2 < 605 2F 00 1A 00 00 00 00 00
        3 < 605 23 00 1A 01 20 00 00 70
        4 < 605 23 00 1A 01 08 09 00 60
        5 < 605 23 00 1A 01 20 00 00 20
        6 < 605 23 00 1A 01 20 00 01 20
        7 < 605 23 00 1A 01 08 01 00 62
        8 < 605 23 00 1A 01 08 01 00 60
        9 < 605 23 00 1A 01 20 01 00 60
        10 < 605 23 00 1A 01 0F 01 00 60
        11 < 605 23 00 1A 01 00 01 00 60
        12 < 605 23 00 1A 01 08 00 05 00
        13 < 605 23 00 1A 01 00 00 00 00
        20 < 605 23 00 14 01 05 02 00 80
        21 < 605 2F 00 16 00 00 00 00 00
        22 < 605 23 00 16 01 08 02 00 60
        23 < 605 23 00 16 01 20 00 00 20
        24 < 605 23 00 16 01 01 00 01 00
        25 < 605 23 00 16 01 10 00 05 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 00 18 01 85 01 00 80
            0001 > 585 [8] 60 00 18 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 605 [8] 2F 00 1A 00 00 00 00 00
            0002 > 585 [8] 60 00 1A 00 00 00 00 00
            0003 < 605 [8] 23 00 1A 01 20 00 00 70
            0003 > 585 [8] 80 00 1A 01 00 00 02 06
            0004 < 605 [8] 23 00 1A 01 08 09 00 60
            0004 > 585 [8] 80 00 1A 01 00 00 02 06
            0005 < 605 [8] 23 00 1A 01 20 00 00 20
            0005 > 585 [8] 80 00 1A 01 41 00 04 06
            0006 < 605 [8] 23 00 1A 01 20 00 01 20
            0006 > 585 [8] 80 00 1A 01 41 00 04 06
            0007 < 605 [8] 23 00 1A 01 08 01 00 62
            0007 > 585 [8] 80 00 1A 01 41 00 04 06
            0008 < 605 [8] 23 00 1A 01 08 01 00 60
            0008 > 585 [8] 80 00 1A 01 41 00 04 06
            0009 < 605 [8] 23 00 1A 01 20 01 00 60
            0009 > 585 [8] 80 00 1A 01 41 00 04 06
            0010 < 605 [8] 23 00 1A 01 0F 01 00 60
            0010 > 585 [8] 80 00 1A 01 41 00 04 06
            0011 < 605 [8] 23 00 1A 01 00 01 00 60
            0011 > 585 [8] 80 00 1A 01 41 00 04 06
            0012 < 605 [8] 23 00 1A 01 08 00 05 00
            0012 > 585 [8] 80 00 1A 01 00 00 02 06
            0013 < 605 [8] 23 00 1A 01 00 00 00 00
            0013 > 585 [8] 60 00 1A 01 00 00 00 00
            0020 < 605 [8] 23 00 14 01 05 02 00 80
            0020 > 585 [8] 60 00 14 01 00 00 00 00
            0020 * FiltersChanged
            0021 < 605 [8] 2F 00 16 00 00 00 00 00
            0021 > 585 [8] 60 00 16 00 00 00 00 00
            0022 < 605 [8] 23 00 16 01 08 02 00 60
            0022 > 585 [8] 80 00 16 01 41 00 04 06
            0023 < 605 [8] 23 00 16 01 20 00 00 20
            0023 > 585 [8] 80 00 16 01 41 00 04 06
            0024 < 605 [8] 23 00 16 01 01 00 01 00
            0024 > 585 [8] 80 00 16 01 00 00 02 06
            0025 < 605 [8] 23 00 16 01 10 00 05 00
            0025 > 585 [8] 80 00 16 01 41 00 04 06
        "#]],
    );
}

/// Conformance case 3.33; CiA 301, section 7.4.7.1: a data type as an entry skips its bytes. Numbers
/// keep their sign.
#[test]
fn dummy_entries_skip_bytes() {
    check(
        "
        0 boot
        1 < 605 23 00 14 01 05 02 00 80
        2 < 605 2F 00 16 00 00 00 00 00
        3 < 605 23 00 16 01 08 00 05 00
        4 < 605 23 00 16 02 10 02 00 62
        5 < 605 23 00 16 03 20 00 07 00
        6 < 605 23 00 16 04 08 01 00 62
        7 < 605 2F 00 16 00 04 00 00 00
        8 < 605 23 00 14 01 05 02 00 00
        9 < 000 01 00
        10 < 205 FF FE FF 11 22 33 44 80
        11 < 605 40 00 62 02 00 00 00 00
        12 < 605 40 00 62 01 00 00 00 00
        13 < 205 FF 01 00 11 22 33 44
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 00 14 01 05 02 00 80
            0001 > 585 [8] 60 00 14 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 605 [8] 2F 00 16 00 00 00 00 00
            0002 > 585 [8] 60 00 16 00 00 00 00 00
            0003 < 605 [8] 23 00 16 01 08 00 05 00
            0003 > 585 [8] 60 00 16 01 00 00 00 00
            0004 < 605 [8] 23 00 16 02 10 02 00 62
            0004 > 585 [8] 60 00 16 02 00 00 00 00
            0005 < 605 [8] 23 00 16 03 20 00 07 00
            0005 > 585 [8] 60 00 16 03 00 00 00 00
            0006 < 605 [8] 23 00 16 04 08 01 00 62
            0006 > 585 [8] 60 00 16 04 00 00 00 00
            0007 < 605 [8] 2F 00 16 00 04 00 00 00
            0007 > 585 [8] 60 00 16 00 00 00 00 00
            0008 < 605 [8] 23 00 14 01 05 02 00 00
            0008 > 585 [8] 60 00 14 01 00 00 00 00
            0008 * FiltersChanged
            0009 < 000 [2] 01 00
            0009 * PreOperational to Operational
            0009 > 185 [3] 00 00 00
            0010 < 205 [8] FF FE FF 11 22 33 44 80
            0011 < 605 [8] 40 00 62 02 00 00 00 00
            0011 > 585 [8] 4B 00 62 02 FE FF 00 00
            0012 < 605 [8] 40 00 62 01 00 00 00 00
            0012 > 585 [8] 4F 00 62 01 80 00 00 00
            0013 < 205 [7] FF 01 00 11 22 33 44
            0013 > 085 [8] 10 82 00 00 00 00 00 00
        "#]],
    );
}

/// CiA 301, section 7.5.2.36: a count of 0 deactivates a mapping. The PDO can be switched on, but it
/// sends nothing, not even on request, and takes no frame.
#[test]
fn a_pdo_that_carries_nothing_neither_sends_nor_listens() {
    check(
        "
        0 boot
        1 < 000 01 00
        2 remote 185 3
        3 < 605 23 00 18 01 85 01 00 80
        4 < 605 2F 00 1A 00 00 00 00 00
        5 < 605 23 00 18 01 85 01 00 00
        6 remote 185 3
        7 set 6000:01 7
        8 trigger 0
        10 < 605 23 00 14 01 05 02 00 80
        11 < 605 2F 00 16 00 00 00 00 00
        12 < 605 23 00 14 01 05 02 00 00
        13 < 205
        14 < 205 01
        15 < 605 40 00 62 01 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0001 > 185 [3] 00 00 00
            0002 < 185 [3] remote
            0002 > 185 [3] 00 00 00
            0003 < 605 [8] 23 00 18 01 85 01 00 80
            0003 > 585 [8] 60 00 18 01 00 00 00 00
            0003 * FiltersChanged
            0004 < 605 [8] 2F 00 1A 00 00 00 00 00
            0004 > 585 [8] 60 00 1A 00 00 00 00 00
            0005 < 605 [8] 23 00 18 01 85 01 00 00
            0005 > 585 [8] 60 00 18 01 00 00 00 00
            0006 < 185 [3] remote
            0010 < 605 [8] 23 00 14 01 05 02 00 80
            0010 > 585 [8] 60 00 14 01 00 00 00 00
            0010 * FiltersChanged
            0011 < 605 [8] 2F 00 16 00 00 00 00 00
            0011 > 585 [8] 60 00 16 00 00 00 00 00
            0012 < 605 [8] 23 00 14 01 05 02 00 00
            0012 > 585 [8] 60 00 14 01 00 00 00 00
            0013 < 205 [0]
            0014 < 205 [1] 01
            0015 < 605 [8] 40 00 62 01 00 00 00 00
            0015 > 585 [8] 4F 00 62 01 00 00 00 00
        "#]],
    );
}

/// A product may change its mapping while the PDO is on. The event timer begins anew and the data go
/// out as when the PDO is switched on; the inhibit time is that of the identifier, and goes on.
#[test]
fn a_pdo_begins_anew_with_another_mapping() {
    check(
        "
        0 set 1800:03 300, 1800:05 100
        0 boot
        10 < 000 01 00
        60 set 6000:02 5
        70 set 1A00:02 1610613536
        80 set 6000:02 6
        260 set 1A00:00 1
        400 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0010 < 000 [2] 01 00
            0010 * PreOperational to Operational
            0010 > 185 [3] 00 00 00
            0060 > 185 [3] 00 00 05
            0090 > 185 [6] 00 00 00 00 00 00
            0190 > 185 [6] 00 00 00 00 00 00
            0260 > 185 [2] 00 00
            0360 > 185 [2] 00 00
        "#]],
    );
}

/// What a master could not write maps nothing where it is a product's own.
#[test]
fn a_count_above_eight_maps_nothing() {
    check(
        "
        0 set 1A00:00 9, 1600:00 9
        0 boot
        1 < 000 01 00
        2 set 6000:01 7
        3 remote 185 3
        4 < 205
        5 < 205 01
        6 < 605 40 00 62 01 00 00 00 00
        7 set 1A00:00 2, 1600:00 1
        8 < 205 01
        9 < 605 40 00 62 01 00 00 00 00
        ",
        expect![[r#"
            0000 * FiltersChanged
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0003 < 185 [3] remote
            0004 < 205 [0]
            0005 < 205 [1] 01
            0006 < 605 [8] 40 00 62 01 00 00 00 00
            0006 > 585 [8] 4F 00 62 01 00 00 00 00
            0007 * FiltersChanged
            0007 > 185 [3] 07 00 00
            0008 < 205 [1] 01
            0009 < 605 [8] 40 00 62 01 00 00 00 00
            0009 > 585 [8] 4F 00 62 01 01 00 00 00
        "#]],
    );
}

/// An entry that a master may try, and its length in a transmit PDO.
const TRIED: &[(u32, Result<u8, u32>)] = &[
    (0x6000_0110, Ok(2)),
    (0x6000_0208, Ok(1)),
    (0x6000_0320, Ok(4)),
    (0x6200_0210, Ok(2)),
    (0x6200_0108, Err(NOT_MAPPABLE)),
    (0x2000_0020, Err(NOT_MAPPABLE)),
    (0x2001_0020, Err(NOT_MAPPABLE)),
    (0x6000_0118, Err(NOT_MAPPABLE)),
    (0x0005_0008, Err(NO_OBJECT)),
    (0x6000_0420, Err(NO_OBJECT)),
];
const EMPTY: (u32, Result<u8, u32>) = (0, Err(NO_OBJECT));
const INITIAL: [(u32, Result<u8, u32>); 2] = [(0x6000_0110, Ok(2)), (0x6000_0208, Ok(1))];

const NO_OBJECT: u32 = 0x0602_0000;
const NOT_MAPPABLE: u32 = 0x0604_0041;
const MAPPING_LENGTH: u32 = 0x0604_0042;
const UNSUPPORTED_ACCESS: u32 = 0x0601_0000;

#[derive(Clone, Debug)]
enum Step {
    Switch { on: bool },
    Count(u8),
    Entry { sub: u8, tried: (u32, Result<u8, u32>) },
    Input { raw: u32 },
}

fn step() -> impl Strategy<Value = Step> {
    let tried = prop::sample::select(TRIED);
    prop_oneof![
        2 => any::<bool>().prop_map(|on| Step::Switch { on }),
        2 => prop_oneof![Just(0), 0..=9_u8].prop_map(Step::Count),
        4 => (1..=8_u8, prop_oneof![8 => tried, 1 => Just(EMPTY)])
            .prop_map(|(sub, tried)| Step::Entry { sub, tried }),
        1 => any::<u32>().prop_map(|raw| Step::Input { raw }),
    ]
}

/// The mapping of a transmit PDO as a plain reading of CiA 301 has it.
struct Model {
    on: bool,
    count: u8,
    entries: [(u32, Result<u8, u32>); 8],
}

impl Model {
    fn new() -> Self {
        let mut entries = [EMPTY; 8];
        entries[..2].copy_from_slice(&INITIAL);
        Self { on: true, count: 2, entries }
    }

    fn set_count(&mut self, count: u8) -> Result<(), u32> {
        if self.on {
            return Err(UNSUPPORTED_ACCESS);
        }
        let entries = self.entries.get(..usize::from(count)).ok_or(MAPPING_LENGTH)?;
        let mut len = 0;
        for (_, tried) in entries {
            len += (*tried)?;
        }
        if len > 8 {
            return Err(MAPPING_LENGTH);
        }
        self.count = count;
        Ok(())
    }

    fn set_entry(&mut self, sub: u8, tried: (u32, Result<u8, u32>)) -> Result<(), u32> {
        if self.on || self.count > 0 {
            return Err(UNSUPPORTED_ACCESS);
        }
        if tried != EMPTY {
            tried.1?;
        }
        self.entries[usize::from(sub) - 1] = tried;
        Ok(())
    }

    /// The data of the PDO, if it goes out.
    fn data(&self, node: &Node<LEN>) -> Option<Vec<u8>> {
        let mapped = self.entries.iter().take(usize::from(self.count));
        let bytes = mapped.flat_map(|&(raw, len)| {
            let [_, sub, low, high] = raw.to_le_bytes();
            let object = ObjectId { index: u16::from_le_bytes([low, high]), sub };
            let number = node.values().raw(DICTIONARY.find(object).unwrap()).to_le_bytes();
            number.into_iter().take(len.map_or(0, usize::from))
        });
        (self.on && self.count > 0).then(|| bytes.collect())
    }
}

fn receive(node: &mut Node<LEN>, id: u16, data: &[u8]) -> Vec<Frame> {
    let frame = Frame::new(CanId::new(id).unwrap(), data).unwrap();
    node.handle_frame(Instant::ZERO, &frame, &mut ());
    while node.poll_event().is_some() {}
    core::iter::from_fn(|| node.take_transmit()).collect()
}

/// The abort code that answers a download, if one does.
fn download(node: &mut Node<LEN>, command: u8, index: u16, sub: u8, raw: u32) -> Result<(), u32> {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = raw.to_le_bytes();
    let answers = receive(node, 0x605, &[command, low, high, sub, a, b, c, d]);
    let answer = answers.iter().find(|frame| frame.id().get() == 0x585).unwrap();
    match *answer.data() {
        [0x60, ..] => Ok(()),
        [0x80, _, _, _, a, b, c, d] => Err(u32::from_le_bytes([a, b, c, d])),
        ref data => panic!("{data:02X?}"),
    }
}

/// NM17x: products share their PDOs. What one of them does not have is zero in its frames, and its
/// numbers are dropped on reception.
#[test]
fn a_product_may_map_objects_that_it_does_not_have() {
    let mut node = node(&Settings::CIA_301);
    let mut set = |index, sub, raw| {
        let slot = DICTIONARY.find(ObjectId { index, sub }).unwrap();
        node.set_value(Instant::ZERO, slot, raw);
    };
    for (sub, raw) in [(0, 3), (1, 0x6000_0110), (2, 0x6000_0420), (3, 0x6000_0208)] {
        set(0x1A00, sub, raw);
    }
    for (sub, raw) in [(0, 2), (1, 0x6200_0420), (2, 0x6200_0108)] {
        set(0x1600, sub, raw);
    }
    set(0x1800, 2, 1);
    set(0x6000, 1, 0xFFFF_FFFE);
    set(0x6000, 2, 7);
    node.boot(Instant::ZERO);
    receive(&mut node, 0x000, &[0x01, 0]);
    let sent = receive(&mut node, 0x080, &[]);
    assert_eq!(sent[0].data(), [0xFE, 0xFF, 0, 0, 0, 0, 7]);
    receive(&mut node, 0x205, &[1, 2, 3, 4, 5]);
    let output = DICTIONARY.find(ObjectId { index: 0x6200, sub: 1 }).unwrap();
    assert_eq!(node.values().raw(output), 5);
}

proptest! {
    /// Conformance cases 3.21 to 3.32: whatever a master writes, the answers are those of the model,
    /// and a frame has the bytes of the objects that the mapping then names.
    #[test]
    fn a_pdo_carries_what_its_mapping_says(steps in vec(step(), 0..60)) {
        let mut node = node(&Settings::CIA_301);
        let type_1 = DICTIONARY.find(ObjectId { index: 0x1800, sub: 2 }).unwrap();
        node.set_value(Instant::ZERO, type_1, 1);
        node.boot(Instant::ZERO);
        receive(&mut node, 0x000, &[0x01, 0]);
        let mut model = Model::new();
        for step in steps {
            match step {
                Step::Switch { on } => {
                    let cob_id = if on { 0x0000_0185 } else { 0x8000_0185 };
                    prop_assert_eq!(download(&mut node, 0x23, 0x1800, 1, cob_id), Ok(()));
                    model.on = on;
                }
                Step::Count(count) => {
                    let answer = download(&mut node, 0x2F, 0x1A00, 0, count.into());
                    prop_assert_eq!(answer, model.set_count(count));
                }
                Step::Entry { sub, tried } => {
                    let answer = download(&mut node, 0x23, 0x1A00, sub, tried.0);
                    prop_assert_eq!(answer, model.set_entry(sub, tried));
                }
                Step::Input { raw } => {
                    let input = DICTIONARY.find(ObjectId { index: 0x6000, sub: 3 }).unwrap();
                    node.set_value(Instant::ZERO, input, raw);
                }
            }
            let sent = receive(&mut node, 0x080, &[]);
            let data = sent.iter().find(|frame| frame.id().get() == 0x185);
            prop_assert_eq!(data.map(|frame| frame.data().to_vec()), model.data(&node));
        }
    }
}
