//! Cases 5.1 to 5.6: emergency messages.

use crate::Case;
use crate::master::{Lacking, Master, Sent, Verdict, object};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "5.1", intent: "the identifier in 0x1014", clause: "7.5.2.17", run: case_5_1 },
    Case { number: "5.2", intent: "no error in the error register", clause: "7.5.2.2", run: case_5_2 },
    Case { number: "5.3", intent: "no error in the pre-defined error field", clause: "7.5.2.4", run: case_5_3 },
    Case { number: "5.4", intent: "a message when an error comes", clause: "7.2.7.1", run: case_5_4 },
    Case { number: "5.5", intent: "the error in the error register", clause: "7.5.2.2", run: case_5_5 },
    Case { number: "5.6", intent: "the error in the pre-defined error field", clause: "7.5.2.4", run: case_5_6 },
];

/// A node that is made to be missed.
const MISSED: u8 = 5;

/// Emergency 01.
fn case_5_1(master: &mut Master) -> Verdict {
    let object = master.has(0x1014, 0)?;
    assert_eq!(master.number(object), u32::from(master.id(0x080)));
    Ok(())
}

/// Emergency 02.
fn case_5_2(master: &mut Master) -> Verdict {
    assert_eq!(master.number(object(0x1001, 0)), 0);
    Ok(())
}

/// Emergency 03: an entry that holds no error has no value to read (CiA 301, section 7.5.2.4).
fn case_5_3(master: &mut Master) -> Verdict {
    let count = master.has(0x1003, 0)?;
    assert_eq!(master.set(count, 0), Ok(()));
    assert_eq!(master.number(count), 0);
    assert_eq!(master.upload(object(0x1003, 1)), Err(0x0800_0024));
    Ok(())
}

/// Emergency 04.
fn case_5_4(master: &mut Master) -> Verdict {
    let message = forced(master)?;
    assert_eq!(message.data[..2], [0x30, 0x81], "a monitored node is missing");
    recover(master);
    Ok(())
}

/// Emergency 05: the register of the message is that of the object, until the error is gone.
fn case_5_5(master: &mut Master) -> Verdict {
    let message = forced(master)?;
    let register = master.number(object(0x1001, 0));
    assert_eq!((u32::from(message.data[2]), register & 0x11), (register, 0x11));
    recover(master);
    assert_eq!(master.number(object(0x1001, 0)), 0);
    Ok(())
}

/// Emergency 06.
fn case_5_6(master: &mut Master) -> Verdict {
    let field = master.has(0x1003, 1)?;
    let message = forced(master)?;
    let entry = master.number(field);
    assert_eq!(entry & 0xFFFF, u32::from(message.data[0]) | u32::from(message.data[1]) << 8);
    recover(master);
    Ok(())
}

/// The message about a node that was there and is missed.
fn forced(master: &mut Master) -> Result<Sent, Lacking> {
    let monitored = master.writes(0x1016, 1)?;
    assert_eq!(master.set(monitored, u32::from(MISSED) << 16 | 100), Ok(()));
    master.send(0x700 + u16::from(MISSED), &[5]);
    let id = master.id(0x080);
    let frames = master.watch_ms(300);
    let messages: Vec<_> = frames.into_iter().filter(|frame| frame.id == id).collect();
    let [message] = messages.as_slice() else { panic!("one message, not {messages:?}") };
    assert_eq!(message.data.len(), 8);
    Ok(message.clone())
}

/// The node is there again and no longer monitored.
fn recover(master: &mut Master) {
    master.send(0x700 + u16::from(MISSED), &[5]);
    master.run_ms(20);
    assert_eq!(master.set(object(0x1016, 1), 0), Ok(()));
    assert_eq!(master.set(object(0x1003, 0), 0), Ok(()));
}
