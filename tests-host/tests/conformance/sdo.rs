//! Cases 2.1 to 2.30: the SDO server.

use std::ops::RangeInclusive;

use object_dictionary::{Access, DataType, ObjectId, Row};

use crate::Case;
use crate::master::{
    AbortCode, Crc, Lacking, Master, Verdict, abort_code, initiate, name, object, refused,
};
use crate::store;

const UNKNOWN_COMMAND: AbortCode = 0x0504_0001;
const TOGGLE: AbortCode = 0x0503_0000;
const READ_ONLY: &[AbortCode] = &[0x0601_0000, 0x0601_0002];
const WRITE_ONLY: &[AbortCode] = &[0x0601_0000, 0x0601_0001];
const NO_OBJECT: AbortCode = 0x0602_0000;
const NO_SUB_INDEX: AbortCode = 0x0609_0011;
const TOO_LONG: &[AbortCode] = &[0x0607_0010, 0x0607_0012];
const TOO_SHORT: &[AbortCode] = &[0x0607_0010, 0x0607_0013];
const OUT_OF_RANGE: &[AbortCode] = &[0x0609_0030, 0x0609_0031, 0x0609_0032];

const DEVICE_TYPE: ObjectId = object(0x1000, 0);
const DEVICE_NAME: ObjectId = object(0x1008, 0);

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "2.1", intent: "an expedited upload", clause: "7.2.4.3.5", run: case_2_1 },
    Case { number: "2.2", intent: "all of 0x1000 to 0x1FFF that is rw is read and written back", clause: "7.5.2", run: case_2_2 },
    Case { number: "2.3", intent: "a write to a constant", clause: "7.2.4.3.17", run: case_2_3 },
    Case { number: "2.4", intent: "a read of what is write only", clause: "7.2.4.3.17", run: case_2_4 },
    Case { number: "2.5", intent: "a sub-index that is not there", clause: "7.2.4.3.17", run: case_2_5 },
    Case { number: "2.6", intent: "an index that is not there", clause: "7.2.4.3.17", run: case_2_6 },
    Case { number: "2.7", intent: "a command that is none", clause: "7.2.4.3.17", run: case_2_7 },
    Case { number: "2.8", intent: "four bytes for a shorter object", clause: "7.2.4.3.17", run: case_2_8 },
    Case { number: "2.9", intent: "one byte for a longer object", clause: "7.2.4.3.17", run: case_2_9 },
    Case { number: "2.10", intent: "a value above the largest", clause: "7.2.4.3.17", run: case_2_10 },
    Case { number: "2.11", intent: "a value below the smallest", clause: "7.2.4.3.17", run: case_2_11 },
    Case { number: "2.12", intent: "the identifiers in 0x1200", clause: "7.5.2.33", run: case_2_12 },
    Case { number: "2.13", intent: "a short value as the server likes to send it", clause: "7.2.4.3.6", run: case_2_13 },
    Case { number: "2.14", intent: "0x100C in segments", clause: "7.2.4.3.3", run: case_2_14 },
    Case { number: "2.15", intent: "0x1017 in segments", clause: "7.2.4.3.3", run: case_2_15 },
    Case { number: "2.16", intent: "the size of a long value", clause: "7.2.4.3.5", run: case_2_16 },
    Case { number: "2.17", intent: "a segment with the wrong toggle bit", clause: "7.2.4.3.6", run: case_2_17 },
    Case { number: "2.18", intent: "a long value in segments", clause: "7.2.4.3.6", run: case_2_18 },
    Case { number: "2.19", intent: "0x1000 in blocks, without checksum", clause: "7.2.4.3.12", run: case_2_19 },
    Case { number: "2.20", intent: "0x100C in blocks, without checksum", clause: "7.2.4.3.8", run: case_2_20 },
    Case { number: "2.21", intent: "0x1017 in blocks, without checksum", clause: "7.2.4.3.8", run: case_2_21 },
    Case { number: "2.22", intent: "a long value in blocks", clause: "7.2.4.3.13", run: case_2_22 },
    Case { number: "2.23", intent: "a long value in blocks with checksum", clause: "7.2.4.3.15", run: case_2_23 },
    Case { number: "2.24", intent: "0x100C in blocks with checksum", clause: "7.2.4.3.11", run: case_2_24 },
    Case { number: "2.25", intent: "0x1017 in blocks with checksum", clause: "7.2.4.3.11", run: case_2_25 },
    Case { number: "2.26", intent: "blocks of 128 segments", clause: "7.2.4.3.12", run: case_2_26 },
    Case { number: "2.27", intent: "segment 128 of a block acknowledged", clause: "7.2.4.3.14", run: case_2_27 },
    Case { number: "2.28", intent: "no further SDO servers", clause: "7.5.2.33", run: case_2_28 },
    Case { number: "2.29", intent: "no further SDO servers after Reset Communication", clause: "7.5.2.33", run: case_2_29 },
    Case { number: "2.30", intent: "no SDO clients, also after a store and Reset Communication", clause: "7.5.2.34", run: case_2_30 },
];

/// SDO 01.
fn case_2_1(master: &mut Master) -> Verdict {
    let answer = master.request(initiate(0x40, DEVICE_TYPE, [0; 4]));
    let row = master.row(DEVICE_TYPE).expect("every device has a type");
    assert_eq!(answer[1..], initiate(0x43, DEVICE_TYPE, row.initial(0).to_le_bytes())[1..]);
    // The length need not be indicated.
    assert!(matches!(answer[0], 0x42 | 0x43), "{:#04x}", answer[0]);
    Ok(())
}

/// SDO 02: not at random, but all.
fn case_2_2(master: &mut Master) -> Verdict {
    for row in rows(master, Access::ReadWrite) {
        // What can not be written while the PDO is valid.
        let fixed = match row.id().index {
            0x1600..0x1800 | 0x1A00..0x1C00 => true,
            0x1800..0x1A00 => matches!(row.id().sub, 3 | 6),
            _ => false,
        };
        if row.id().index < 0x2000 && !fixed && !master.is_command(row) {
            let value = master.upload(row.id());
            // An object may have no value now: the empty error field.
            if let Ok(value) = value {
                assert_eq!(master.download(row.id(), &value), Ok(()), "{}", name(row.id()));
                assert_eq!(master.upload(row.id()), Ok(value), "{}", name(row.id()));
            }
        }
    }
    Ok(())
}

/// SDO 03.
fn case_2_3(master: &mut Master) -> Verdict {
    refused(master.download(DEVICE_TYPE, &[0; 4]), READ_ONLY)
}

/// SDO 04.
fn case_2_4(master: &mut Master) -> Verdict {
    let row = first(master, Access::WriteOnly, |_| true).ok_or("nothing is write only")?;
    refused(master.upload(row.id()), WRITE_ONLY)
}

/// SDO 05.
fn case_2_5(master: &mut Master) -> Verdict {
    refused(master.upload(object(0x1000, 1)), &[NO_SUB_INDEX])
}

/// SDO 06.
fn case_2_6(master: &mut Master) -> Verdict {
    refused(master.upload(object(0x1004, 0)), &[NO_OBJECT])
}

/// SDO 07.
fn case_2_7(master: &mut Master) -> Verdict {
    for command in [0xE0, 0xFF, 0x9F] {
        let answer = master.request(initiate(command, DEVICE_TYPE, [0; 4]));
        assert_eq!((answer[0], abort_code(answer)), (0x80, UNKNOWN_COMMAND), "{command:#04x}");
    }
    Ok(())
}

/// SDO 08.
fn case_2_8(master: &mut Master) -> Verdict {
    let short = |row: Row| matches!(row.data_type().len(), 1 | 2);
    let row = first(master, Access::ReadWrite, short).ok_or("no short object is rw")?;
    refused(master.download(row.id(), &[0; 4]), TOO_LONG)
}

/// SDO 09.
fn case_2_9(master: &mut Master) -> Verdict {
    let long = |row: Row| matches!(row.data_type().len(), 2 | 4);
    let row = first(master, Access::ReadWrite, long).ok_or("no long object is rw")?;
    refused(master.download(row.id(), &[0]), TOO_SHORT)
}

/// SDO 10.
fn case_2_10(master: &mut Master) -> Verdict {
    beyond(master, |row, (_, max)| row.limits().max.checked_add(1).filter(|&above| above <= max))
}

/// SDO 11.
fn case_2_11(master: &mut Master) -> Verdict {
    beyond(master, |row, (min, _)| row.limits().min.checked_sub(1).filter(|&below| below >= min))
}

/// Writes the value that `outside` finds for each object, and expects it to be refused.
fn beyond(master: &mut Master, outside: fn(Row, (i64, i64)) -> Option<i64>) -> Verdict {
    let mut any = false;
    for row in rows(master, Access::ReadWrite) {
        let Some(value) = outside(row, row.data_type().span()) else { continue };
        if master.is_command(row) || row.permits(raw(value)) {
            continue;
        }
        let before = master.upload(row.id());
        let len = row.data_type().len();
        let written = master.download(row.id(), &value.to_le_bytes()[..len]);
        refused(written, OUT_OF_RANGE)?;
        assert_eq!(master.upload(row.id()), before, "{} is what it was", name(row.id()));
        any = true;
    }
    if any { Ok(()) } else { Err("no object has such a limit".into()) }
}

/// SDO 12.
fn case_2_12(master: &mut Master) -> Verdict {
    for (sub, function_code) in [(1, 0x600), (2, 0x580)] {
        let object = master.has(0x1200, sub)?;
        assert_eq!(master.number(object), u32::from(master.id(function_code)));
    }
    Ok(())
}

/// SDO 13: four bytes go expedited, which clients have to take.
fn case_2_13(master: &mut Master) -> Verdict {
    let expected = master.row(DEVICE_TYPE).expect("every device has a type").initial(0);
    assert_eq!(master.upload(DEVICE_TYPE), Ok(expected.to_le_bytes().to_vec()));
    Ok(())
}

/// SDO 14.
fn case_2_14(master: &mut Master) -> Verdict {
    let object = master.writes(0x100C, 0)?;
    written_by(master, object, |master| master.download_in_segments(object, &[0x2C, 0x01]))
}

/// SDO 15.
fn case_2_15(master: &mut Master) -> Verdict {
    let object = master.writes(0x1017, 0)?;
    written_by(master, object, |master| master.download_in_segments(object, &[0x2C, 0x01]))
}

/// SDO 16.
fn case_2_16(master: &mut Master) -> Verdict {
    let row = long_text(master)?;
    let answer = master.request(initiate(0x40, row.id(), [0; 4]));
    let size = u32::try_from(row.data_type().len()).expect("a short text");
    assert_eq!(answer, initiate(0x41, row.id(), size.to_le_bytes()));
    Ok(())
}

/// SDO 17.
fn case_2_17(master: &mut Master) -> Verdict {
    let row = long_text(master)?;
    master.request(initiate(0x40, row.id(), [0; 4]));
    refused(master.upload_segment(0x10), &[TOGGLE])?;
    refused(master.upload_segment(0x00), &[UNKNOWN_COMMAND])?;
    assert!(master.upload(row.id()).is_ok(), "the next transfer is not disturbed");
    Ok(())
}

/// SDO 18.
fn case_2_18(master: &mut Master) -> Verdict {
    let row = long_text(master)?;
    let value = master.upload(row.id()).expect("a text");
    assert_eq!(value.len(), row.data_type().len());
    Ok(())
}

/// SDO 19.
fn case_2_19(master: &mut Master) -> Verdict {
    blocks(master)?;
    let expected = master.upload(DEVICE_TYPE);
    assert_eq!(master.upload_in_blocks(DEVICE_TYPE, Crc::Without), expected);
    Ok(())
}

/// SDO 20.
fn case_2_20(master: &mut Master) -> Verdict {
    block_written(master, 0x100C, Crc::Without)
}

/// SDO 21.
fn case_2_21(master: &mut Master) -> Verdict {
    block_written(master, 0x1017, Crc::Without)
}

/// SDO 22.
fn case_2_22(master: &mut Master) -> Verdict {
    block_read(master, Crc::Without)
}

/// SDO 23.
fn case_2_23(master: &mut Master) -> Verdict {
    block_read(master, Crc::Asked)
}

/// SDO 24.
fn case_2_24(master: &mut Master) -> Verdict {
    block_written(master, 0x100C, Crc::Asked)
}

/// SDO 25.
fn case_2_25(master: &mut Master) -> Verdict {
    block_written(master, 0x1017, Crc::Asked)
}

/// SDO 26.
fn case_2_26(master: &mut Master) -> Verdict {
    blocks(master)?;
    let answer = master.request(initiate(0xA0, DEVICE_NAME, [128, 0, 0, 0]));
    assert_eq!((answer[0], abort_code(answer)), (0x80, 0x0504_0002));
    Ok(())
}

/// SDO 27: the acknowledged segment does not exist.
fn case_2_27(master: &mut Master) -> Verdict {
    blocks(master)?;
    let answer = master.request(initiate(0xA0, DEVICE_TYPE, [127, 0, 0, 0]));
    assert_eq!(answer[0] & 0xF9, 0xC0);
    let segment = master.request([0xA3, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(segment[0], 0x81, "the only segment");
    let answer = master.request([0xA2, 128, 127, 0, 0, 0, 0, 0]);
    assert_eq!((answer[0], abort_code(answer)), (0x80, 0x0504_0003));
    Ok(())
}

/// SDO 28.
fn case_2_28(master: &mut Master) -> Verdict {
    are_missing(master, 0x1201..=0x1208)
}

/// SDO 29.
fn case_2_29(master: &mut Master) -> Verdict {
    reset_communication(master);
    case_2_28(master)
}

/// SDO 30.
fn case_2_30(master: &mut Master) -> Verdict {
    const CLIENTS: RangeInclusive<u16> = 0x1280..=0x1288;
    are_missing(master, CLIENTS)?;
    let stores = master.device.stored.is_some();
    if stores {
        store::save(master)?;
    }
    reset_communication(master);
    are_missing(master, CLIENTS)?;
    if stores { store::restore(master) } else { Ok(()) }
}

fn are_missing(master: &mut Master, mut indexes: RangeInclusive<u16>) -> Verdict {
    indexes.try_for_each(|index| refused(master.upload(object(index, 0)), &[NO_OBJECT]))
}

fn reset_communication(master: &mut Master) {
    master.nmt(0x82);
    master.run_ms(1_000);
}

/// The low 32 bits of a number.
fn raw(value: i64) -> u32 {
    let [a, b, c, d, ..] = value.to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

/// The rows with this access, in ascending order.
fn rows(master: &Master, access: Access) -> impl Iterator<Item = Row> + use<> {
    master.rows().filter(move |row| row.access() == access)
}

/// The first number with this access that suits, other than commands.
fn first(master: &Master, access: Access, suits: fn(Row) -> bool) -> Option<Row> {
    let number = |row: Row| !matches!(row.data_type(), DataType::VisibleString(_));
    rows(master, access).find(|&row| number(row) && suits(row) && !master.is_command(row))
}

/// The first text that does not fit into one frame.
fn long_text(master: &Master) -> Result<Row, Lacking> {
    let long = |row: &Row| row.data_type().len() > 4;
    master.rows().find(long).ok_or_else(|| "no value is longer than four bytes".to_owned())
}

/// Whether the product serves block transfers; CiA 301 leaves it to the product.
fn blocks(master: &mut Master) -> Verdict {
    let answer = master.request(initiate(0xA0, DEVICE_TYPE, [127, 0, 0, 0]));
    if answer[0] == 0x80 {
        assert_eq!(abort_code(answer), UNKNOWN_COMMAND);
        return Err("no block transfer".into());
    }
    // The client gives up again.
    master.send(master.id(0x600), &initiate(0x80, DEVICE_TYPE, [0; 4]));
    master.run_ms(5);
    Ok(())
}

fn block_read(master: &mut Master, crc: Crc) -> Verdict {
    blocks(master)?;
    let row = long_text(master)?;
    let expected = master.upload(row.id());
    assert_eq!(master.upload_in_blocks(row.id(), crc), expected);
    Ok(())
}

fn block_written(master: &mut Master, index: u16, crc: Crc) -> Verdict {
    let object = master.writes(index, 0)?;
    blocks(master)?;
    written_by(master, object, |master| master.download_in_blocks(object, &[0x2C, 0x01], crc))
}

/// 300 arrives in the object, which then gets its value back.
fn written_by(
    master: &mut Master,
    object: ObjectId,
    write: impl FnOnce(&mut Master) -> Result<(), AbortCode>,
) -> Verdict {
    let before = master.number(object);
    match write(master) {
        Err(UNKNOWN_COMMAND) => return Err("expedited transfers alone".into()),
        written => assert_eq!(written, Ok(())),
    }
    assert_eq!(master.number(object), 300);
    assert_eq!(master.set(object, before), Ok(()));
    Ok(())
}
