//! What a master has shown on the display.

use expect_test::expect;

use crate::script::Script;

/// NM17x OD-2007-1, DISP-17, SDO-06, SDO-08, A-19: twelve characters, in segments.
#[test]
fn a_text_is_twelve_characters() {
    let mut script = Script::booted();
    script.send("67F#40 07 20 00 00 00 00 00").send("67F#60 00 00 00 00 00 00 00");
    script.send("67F#70 00 00 00 00 00 00 00");
    script.send("67F#21 07 20 00 0C 00 00 00");
    script.send("67F#00 53 54 4F 50 20 20 31").send("67F#15 32 2E 33 34 5F 00 00").run(50);
    script.send("67F#40 07 20 00 00 00 00 00").send("67F#60 00 00 00 00 00 00 00");
    script.send("67F#70 00 00 00 00 00 00 00");
    script.send("67F#21 07 20 00 0B 00 00 00").send("67F#23 07 20 00 41 42 43 44");
    script.expect(expect![[r#"
        500   <-  67F#40 07 20 00 00 00 00 00
        500   ->  5FF#41 07 20 00 0C 00 00 00
        500   <-  67F#60 00 00 00 00 00 00 00
        500   ->  5FF#00 31 32 33 34 35 36 37
        500   <-  67F#70 00 00 00 00 00 00 00
        500   ->  5FF#15 38 39 30 41 42 00 00
        500   <-  67F#21 07 20 00 0C 00 00 00
        500   ->  5FF#60 07 20 00 00 00 00 00
        500   <-  67F#00 53 54 4F 50 20 20 31
        500   ->  5FF#20 00 00 00 00 00 00 00
        500   <-  67F#15 32 2E 33 34 5F 00 00
        500   ->  5FF#30 00 00 00 00 00 00 00
        510   MSP write 2007:1 = 1347376211
        520   MSP write 2007:2 = 842080288
        530   MSP write 2007:3 = 1597256494
        550   <-  67F#40 07 20 00 00 00 00 00
        550   ->  5FF#41 07 20 00 0C 00 00 00
        550   <-  67F#60 00 00 00 00 00 00 00
        550   ->  5FF#00 53 54 4F 50 20 20 31
        550   <-  67F#70 00 00 00 00 00 00 00
        550   ->  5FF#15 32 2E 33 34 5F 00 00
        550   <-  67F#21 07 20 00 0B 00 00 00
        550   ->  5FF#80 07 20 00 30 00 09 06
        550   <-  67F#23 07 20 00 41 42 43 44
        550   ->  5FF#80 07 20 00 30 00 09 06
    "#]]);
}

/// NM17x DISP-19, A-102: writing any object ends the text, one of this controller's included.
#[test]
fn any_write_ends_the_text() {
    let mut script = Script::booted();
    let text = |script: &mut Script| {
        script.send("67F#21 07 20 00 0C 00 00 00").send("67F#00 53 54 4F 50 20 20 31");
        script.send("67F#15 32 2E 33 34 5F 00 00").run(50).transcript.clear();
    };
    text(&mut script);
    script.send("67F#2B 17 10 00 00 00 00 00").run(20).send("67F#2B 17 10 00 00 00 00 00").run(20);
    script.expect(expect![[r#"
        550   <-  67F#2B 17 10 00 00 00 00 00
        550   ->  5FF#60 17 10 00 00 00 00 00
        560   MSP write 2007:4 = 0
        570   <-  67F#2B 17 10 00 00 00 00 00
        570   ->  5FF#60 17 10 00 00 00 00 00
    "#]]);
    text(&mut script);
    script.send("67F#23 08 20 00 01 00 00 00").run(20).send("67F#2B 17 10 00 00 00 00 00").run(20);
    script.expect(expect![[r#"
        640   <-  67F#23 08 20 00 01 00 00 00
        640   ->  5FF#60 08 20 00 00 00 00 00
        650   MSP write 2008:0 = 1
        660   <-  67F#2B 17 10 00 00 00 00 00
        660   ->  5FF#60 17 10 00 00 00 00 00
    "#]]);
}

/// NM17x OD-2048-1, OD-204D-1, OD-204D-2, OD-204D-3, A-40, A-47: commands are confirmed and passed
/// on, and read the state of a motor that is at rest.
#[test]
fn commands_read_the_state_of_the_motor() {
    let mut script = Script::booted();
    for request in [
        "67F#40 4D 20 00 00 00 00 00",
        "67F#2F 4D 20 01 08 00 00 00",
        "67F#40 4D 20 01 00 00 00 00",
        "67F#2F 4D 20 01 09 00 00 00",
        "67F#2F 4D 20 02 01 00 00 00",
        "67F#40 4D 20 02 00 00 00 00",
        "67F#2F 4D 20 03 17 00 00 00",
        "67F#40 4D 20 03 00 00 00 00",
        "67F#2F 4D 20 03 00 00 00 00",
        "67F#2F 48 20 00 01 00 00 00",
        "67F#40 48 20 00 00 00 00 00",
        "67F#2F 48 20 00 02 00 00 00",
    ] {
        script.send(request).run(20);
    }
    script.expect(expect![[r#"
        500   <-  67F#40 4D 20 00 00 00 00 00
        500   ->  5FF#4F 4D 20 00 03 00 00 00
        520   <-  67F#2F 4D 20 01 08 00 00 00
        520   ->  5FF#60 4D 20 01 00 00 00 00
        530   MSP write 204d:1 = 8
        540   <-  67F#40 4D 20 01 00 00 00 00
        540   ->  5FF#4F 4D 20 01 00 00 00 00
        560   <-  67F#2F 4D 20 01 09 00 00 00
        560   ->  5FF#80 4D 20 01 30 00 09 06
        580   <-  67F#2F 4D 20 02 01 00 00 00
        580   ->  5FF#60 4D 20 02 00 00 00 00
        590   MSP write 204d:2 = 1
        600   <-  67F#40 4D 20 02 00 00 00 00
        600   ->  5FF#4F 4D 20 02 00 00 00 00
        620   <-  67F#2F 4D 20 03 17 00 00 00
        620   ->  5FF#60 4D 20 03 00 00 00 00
        630   MSP write 204d:3 = 23
        640   <-  67F#40 4D 20 03 00 00 00 00
        640   ->  5FF#4F 4D 20 03 00 00 00 00
        660   <-  67F#2F 4D 20 03 00 00 00 00
        660   ->  5FF#80 4D 20 03 30 00 09 06
        680   <-  67F#2F 48 20 00 01 00 00 00
        680   ->  5FF#60 48 20 00 00 00 00 00
        690   MSP write 2048:0 = 1
        700   <-  67F#40 48 20 00 00 00 00 00
        700   ->  5FF#4F 48 20 00 00 00 00 00
        720   <-  67F#2F 48 20 00 02 00 00 00
        720   ->  5FF#80 48 20 00 30 00 09 06
    "#]]);
}
