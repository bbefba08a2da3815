use expect_test::expect;

use crate::cia_301;
use crate::script::transcript;

/// CiA 301, sections 7.2.6 and 7.5.2.15: the time of day is an event while bit 31 of 0x1012 is set,
/// in the states with SDO.
#[test]
fn the_time_is_told() {
    let script = "
        0 boot
        1 < 100 78 56 34 F2 10 27
        2 < 100 78 56 34 12 10
        3 < 605 23 12 10 00 01 02 00 80
        4 < 100 00 00 00 00 00 00
        5 < 201 FF FF FF FF FF FF
        6 < 605 23 12 10 00 01 02 00 00
        7 < 201 00 00 00 00 00 00
        8 < 605 23 12 10 00 01 02 00 C0
        9 < 605 23 12 10 00 01 01 00 80
        10 < 605 23 12 10 00 00 01 00 80
        11 < 000 02 00
        12 < 100 00 00 00 00 00 00
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 100 [6] 78 56 34 F2 10 27
        0001 * Time(TimeOfDay { milliseconds: 36984440, days: 10000 })
        0002 < 100 [5] 78 56 34 12 10
        0003 < 605 [8] 23 12 10 00 01 02 00 80
        0003 > 585 [8] 60 12 10 00 00 00 00 00
        0003 * FiltersChanged
        0004 < 100 [6] 00 00 00 00 00 00
        0005 < 201 [6] FF FF FF FF FF FF
        0005 * Time(TimeOfDay { milliseconds: 268435455, days: 65535 })
        0006 < 605 [8] 23 12 10 00 01 02 00 00
        0006 > 585 [8] 60 12 10 00 00 00 00 00
        0006 * FiltersChanged
        0007 < 201 [6] 00 00 00 00 00 00
        0008 < 605 [8] 23 12 10 00 01 02 00 C0
        0008 > 585 [8] 80 12 10 00 30 00 09 06
        0009 < 605 [8] 23 12 10 00 01 01 00 80
        0009 > 585 [8] 80 12 10 00 30 00 09 06
        0010 < 605 [8] 23 12 10 00 00 01 00 80
        0010 > 585 [8] 60 12 10 00 00 00 00 00
        0010 * FiltersChanged
        0011 < 000 [2] 02 00
        0011 * PreOperational to Stopped
        0012 < 100 [6] 00 00 00 00 00 00
    "#]]
    .assert_eq(&transcript(cia_301::node(), &mut (), script));
}
