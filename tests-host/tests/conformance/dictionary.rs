//! Cases 4.1 to 4.9: the object dictionary as its data sheet says.

use object_dictionary::{Access, DataType, Default, Row, Storage, WriteState};

use crate::Case;
use crate::master::{AbortCode, Master, Reason, Verdict, name, object};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "4.1", intent: "0x1000 to 0x1FFF: each object as its access says", clause: "7.4.7", run: case_4_1 },
    Case { number: "4.2", intent: "0x1000 to 0x1FFF: defaults", clause: "7.5.2", run: case_4_2 },
    Case { number: "4.3", intent: "a write to each object that is ro", clause: "7.2.4.3.17", run: case_4_3 },
    Case { number: "4.4", intent: "a read of each object that is wo", clause: "7.2.4.3.17", run: case_4_4 },
    Case { number: "4.5", intent: "sub-index 255", clause: "7.4.4", run: case_4_5 },
    Case { number: "4.6", intent: "both ends of each range", clause: "7.2.4.3.17", run: case_4_6 },
    Case { number: "4.7", intent: "from 0x2000 on: each object as its access says", clause: "7.4.7", run: case_4_7 },
    Case { number: "4.8", intent: "from 0x2000 on: defaults", clause: "7.4.7", run: case_4_8 },
    Case { number: "4.9", intent: "from 0x2000 on: what is rw is read and written back", clause: "7.4.7", run: case_4_9 },
];

const NO_DATA: AbortCode = 0x0800_0024;

/// OD 01.
fn case_4_1(master: &mut Master) -> Verdict {
    each(master, Area::Communication, accessed)
}

/// OD 02.
fn case_4_2(master: &mut Master) -> Verdict {
    master.restart();
    each(master, Area::Communication, is_default)
}

/// OD 03.
fn case_4_3(master: &mut Master) -> Verdict {
    for row in master.rows().filter(|row| row.access() == Access::ReadOnly) {
        let zeros = vec![0; row.data_type().len()];
        let code = master.download(row.id(), &zeros).expect_err("it is refused");
        assert!([0x0601_0000, 0x0601_0002].contains(&code), "{}: {code:08X}", name(row.id()));
    }
    Ok(())
}

/// OD 04.
fn case_4_4(master: &mut Master) -> Verdict {
    let mut verdict = Err(Reason::from("nothing is write only"));
    for row in master.rows().filter(|row| row.access() == Access::WriteOnly) {
        let code = master.upload(row.id()).expect_err("it is refused");
        assert!([0x0601_0000, 0x0601_0001].contains(&code), "{}: {code:08X}", name(row.id()));
        verdict = Ok(());
    }
    verdict
}

/// OD 05: type of the object and, above it, of its data. CiA 301 leaves it to the device to have any.
fn case_4_5(master: &mut Master) -> Verdict {
    const ARRAY: u32 = 0x08;
    assert_eq!(master.upload(object(0x1018, 255)), Err(0x0609_0011));
    let structures: Vec<Row> = master.rows().filter(|row| row.id().sub == 255).collect();
    for row in &structures {
        let first = master.row(object(row.id().index, 1)).expect("an array has elements");
        let expected = ARRAY | code_of(first.data_type()) << 8;
        assert_eq!(master.number(row.id()), expected, "{}", name(row.id()));
    }
    if structures.is_empty() { Err("no object has a sub-index 255".into()) } else { Ok(()) }
}

/// The data type in the numbers of CiA 301, section 7.4.7.1.
fn code_of(data_type: DataType) -> u32 {
    match data_type {
        DataType::Integer8 => 0x02,
        DataType::Integer16 => 0x03,
        DataType::Integer32 => 0x04,
        DataType::Unsigned8 => 0x05,
        DataType::Unsigned16 => 0x06,
        DataType::Unsigned32 => 0x07,
        DataType::VisibleString(_) => 0x09,
    }
}

/// OD 06.
fn case_4_6(master: &mut Master) -> Verdict {
    let mut verdict = Err(Reason::from("no object has limits"));
    for row in master.rows() {
        let written =
            row.access() == Access::ReadWrite && row.write_state() != WriteState::NotWithSdo;
        if !written || row.id().index < 0x2000 || master.is_command(row) {
            continue;
        }
        let limits = row.limits();
        if (limits.min, limits.max) == row.data_type().span() || row.storage() == Storage::Volatile
        {
            continue;
        }
        let before = master.upload(row.id()).expect("a value");
        for end in [limits.min, limits.max] {
            let value = &end.to_le_bytes()[..row.data_type().len()];
            assert_eq!(master.download(row.id(), value), Ok(()), "{} = {end}", name(row.id()));
            assert_eq!(master.upload(row.id()).as_deref(), Ok(value), "{}", name(row.id()));
        }
        assert_eq!(master.download(row.id(), &before), Ok(()), "{}", name(row.id()));
        verdict = Ok(());
    }
    verdict
}

/// OD 07.
fn case_4_7(master: &mut Master) -> Verdict {
    each(master, Area::Device, accessed)
}

/// OD 08.
fn case_4_8(master: &mut Master) -> Verdict {
    master.restart();
    each(master, Area::Device, is_default)
}

/// OD 09.
fn case_4_9(master: &mut Master) -> Verdict {
    each(master, Area::Device, |master, row| {
        if row.access() == Access::ReadWrite
            && row.write_state() != WriteState::NotWithSdo
            && !master.is_command(row)
            && let Ok(value) = master.upload(row.id())
            && row.permits(raw(&value))
        {
            assert_eq!(master.download(row.id(), &value), Ok(()), "{}", name(row.id()));
            assert_eq!(master.upload(row.id()), Ok(value), "{}", name(row.id()));
        }
    })
}

/// The two parts of a dictionary.
#[derive(Clone, Copy, Debug)]
enum Area {
    Communication,
    Device,
}

fn each(master: &mut Master, area: Area, check: fn(&mut Master, Row)) -> Verdict {
    let of_area = |row: &Row| match area {
        Area::Communication => row.id().index < 0x2000,
        Area::Device => row.id().index >= 0x2000,
    };
    for row in master.rows().filter(of_area) {
        check(master, row);
    }
    Ok(())
}

/// An object is read with its length, unless it has no value now, or can not be read.
fn accessed(master: &mut Master, row: Row) {
    let read = master.upload(row.id());
    match (row.access(), read) {
        (Access::WriteOnly, read) => assert_eq!(read, Err(0x0601_0001), "{}", name(row.id())),
        (Access::ReadOnly | Access::ReadWrite, Ok(value)) => {
            assert_eq!(value.len(), row.data_type().len(), "{}", name(row.id()));
        }
        (Access::ReadOnly | Access::ReadWrite, Err(code)) => {
            assert_eq!(code, NO_DATA, "{}", name(row.id()));
        }
    }
}

/// What masters may change starts with its default, and constants are what the data sheet says.
fn is_default(master: &mut Master, row: Row) {
    let fixed = row.access() == Access::ReadOnly && row.limits().min == row.limits().max;
    let set = row.access() == Access::ReadWrite && row.storage() != Storage::Volatile;
    if !fixed && !set {
        return;
    }
    let expected = match row.default() {
        Default::Text(text) => text.as_bytes().to_vec(),
        Default::Number(_) | Default::NodeIdPlus(_) => {
            let number = row.initial(master.device.node_id);
            number.to_le_bytes()[..row.data_type().len()].to_vec()
        }
    };
    assert_eq!(master.upload(row.id()), Ok(expected), "{}", name(row.id()));
}

/// The number that these bytes are; of a text anything.
fn raw(value: &[u8]) -> u32 {
    let mut le = [0; 4];
    for (byte, &read) in le.iter_mut().zip(value) {
        *byte = read;
    }
    u32::from_le_bytes(le)
}
