//! What a person in front of the device sees.

use expect_test::{Expect, expect};
use lcd::{Arrows, Line, View};

#[track_caller]
fn check(view: &View, expected: Expect) {
    expected.assert_eq(&view.to_string());
}

/// NM17x DISP-01, DISP-02: setpoint above, actual value below.
#[test]
fn setpoint_and_actual_value() {
    let view = View {
        upper: Line::number(999_999, 2),
        lower: Line::number(-12_345, 2),
        arrows: Arrows { left: true, right: true },
    };
    check(
        &view,
        expect![[r#"
        ┌────────────────────────┐
        │ _   _   _   _   _   _  │
        │|_| |_| |_| |_| |_| |_| │
        │ _|  _|  _|  _|. _|  _| │
        │         _   _       _  │
        │ _    |  _|  _| |_| |_  │
        │      | |_   _|.  |  _| │
        │◄                      ►│
        └────────────────────────┘"#]],
    );
}

/// NM17x BOOT-01, A-99.
#[test]
fn designation_and_version() {
    let view =
        View { upper: Line::text(b"172.A01"), lower: Line::number(105, 2), arrows: Arrows::NONE };
    check(
        &view,
        expect![[r#"
        ┌────────────────────────┐
        │     _   _   _   _      │
        │  |   |  _| |_| | |   | │
        │  |   | |_ .| | |_|   | │
        │                 _   _  │
        │              | | | |_  │
        │              |.|_|  _| │
        │                        │
        └────────────────────────┘"#]],
    );
}

/// NM17x DISP-18, A-98.
#[test]
fn every_character() {
    let view = |upper: &[u8], lower: &[u8]| View {
        upper: Line::text(upper),
        lower: Line::text(lower),
        arrows: Arrows::NONE,
    };
    check(
        &view(b"012345", b"6789-_"),
        expect![[r#"
        ┌────────────────────────┐
        │ _       _   _       _  │
        │| |   |  _|  _| |_| |_  │
        │|_|   | |_   _|   |  _| │
        │ _   _   _   _          │
        │|_    | |_| |_|  _      │
        │|_|   | |_|  _|      _  │
        │                        │
        └────────────────────────┘"#]],
    );
    check(
        &view(b"ABCDEF", b"GHIJLN"),
        expect![[r#"
        ┌────────────────────────┐
        │ _       _       _   _  │
        │|_| |_  |    _| |_  |_  │
        │| | |_| |_  |_| |_  |   │
        │ _                      │
        │|   |_| |     | |    _  │
        │|_| | | |   |_| |_  | | │
        │                        │
        └────────────────────────┘"#]],
    );
    check(
        &view(b"OPQRST", b"UY ER."),
        expect![[r#"
        ┌────────────────────────┐
        │     _   _       _      │
        │ _  |_| |_|  _  |_  |_  │
        │|_| |     | |    _| |_  │
        │             _          │
        │| | |_|     |_   _      │
        │|_|  _|     |_  |  .    │
        │                        │
        └────────────────────────┘"#]],
    );
}

/// NM17x DISP-11: on the bench the glass is seen upright, so the turned picture stands on its head.
/// The points lie to the upper left of their digits then.
#[test]
fn turned_by_180_degrees() {
    let view = View {
        upper: Line::number(123_456, 2),
        lower: Line::number(-789, 2),
        arrows: Arrows { left: true, right: false },
    };
    check(
        &view.upside_down(),
        expect![[r#"
        ┌────────────────────────┐
        │ _   _                  │
        │|_  |_| |            _  │
        │|_| |_|.|_              │
        │ _   _       _   _      │
        │|_| |_  |_  |_   _| |   │
        │ _|  _|.| | |_  |_  |   │
        │                       ►│
        └────────────────────────┘"#]],
    );
}
