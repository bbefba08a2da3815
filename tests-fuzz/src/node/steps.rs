//! What may happen to a node, read from bytes.

use canopen::{BusState, CanId, Frame, ReadError, WriteError};
use object_dictionary::{ObjectId, Slot};

use super::{Bus, ERROR_CONTROL, LSS_REQUEST, Mood, NMT, SDO_REQUEST, TIME, Watch, is_text};
use crate::bytes::Bytes;

#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Receive(Frame),
    /// A frame is served before what was due since the last step.
    ReceiveAfter {
        us: u64,
        frame: Frame,
    },
    /// A value to be restored at the next start.
    Keep {
        slot: Slot,
        raw: u32,
    },
    Set {
        slot: Slot,
        raw: u32,
    },
    Emergency {
        code: u16,
    },
    Errors {
        register: u8,
    },
    Supervise(BusState),
    Overrun,
    Trigger {
        number: u16,
    },
    Advance {
        us: u64,
    },
    /// Nobody calls for what is due in the meantime.
    Sleep {
        us: u64,
    },
    /// The next step but one comes before what the next one lets be due at once.
    Hurry,
    /// The user touches the device.
    Touch,
    Mood(Mood),
    Bus(Bus),
    Stored(Result<(), WriteError>),
    /// A frame leaves its mailbox again, as for a more urgent one.
    GiveBack,
}

impl<const LEN: usize> Watch<LEN> {
    /// The next thing to happen; `None` at the end of the input.
    pub(super) fn next(&self, bytes: &mut Bytes<'_>) -> Option<Step> {
        match bytes.u8()? {
            240.. => self.sign_of_life(bytes),
            kind => self.step(kind % 24, bytes),
        }
    }

    fn step(&self, kind: u8, bytes: &mut Bytes<'_>) -> Option<Step> {
        let node_id = u16::from(self.subject.node_id.get());
        let frame = |id: u16, data: &[u8]| Frame::new(CanId::new(id).unwrap(), data).unwrap();
        let step = match kind {
            0..=7 => Step::Receive(frame(SDO_REQUEST + node_id, &self.sdo_request(bytes)?)),
            8 => Step::Receive(frame(SDO_REQUEST + node_id, bytes.up_to(8)?)),
            9 => {
                let id = CanId::new(bytes.u16()? & 0x7FF)?;
                Step::Receive(if bytes.u8()? & 1 == 0 {
                    Frame::new(id, bytes.up_to(8)?)?
                } else {
                    Frame::new_remote(id, bytes.u8()? % 9)?
                })
            }
            10 | 11 => {
                let any = bytes.u8()?;
                let command = bytes.pick(&[1, 1, 1, 1, 1, 0x80, 0x80, 2, 0x81, 0x82, any])?;
                let node = bytes.pick(&[0, self.subject.node_id.get(), any])?;
                Step::Receive(frame(NMT, &[command, node]))
            }
            12 | 13 => {
                let id = self.value(ObjectId { index: 0x1005, sub: 0 }).unwrap_or(0x80) & 0x7FF;
                Step::Receive(frame(id as u16, bytes.pick(&[&[][..], &[], &[1], &[1, 2]])?))
            }
            14 | 15 => {
                let ids: Vec<_> = self.node.accepts().collect();
                let accepted = bytes.pick(&ids)?;
                let data = bytes.up_to(8)?;
                Step::Receive(if accepted.remote {
                    Frame::new_remote(accepted.id, data.len() as u8)?
                } else {
                    Frame::new(accepted.id, data)?
                })
            }
            16 => {
                let any = bytes.u8()?;
                let command = bytes.pick(&[4, 0x11, 0x13, 0x15, 0x17, 0x51, 0x5A, 0x5E, any])?;
                let mut data = [command, 0, 0, 0, 0, 0, 0, 0];
                data[1] = bytes.u8()?;
                data[2] = bytes.u8()?;
                Step::Receive(frame(LSS_REQUEST, &data))
            }
            17 | 18 => {
                let position = bytes.u16()? % LEN as u16;
                let slot = Slot::at(self.subject.dictionary, position)?;
                let raw = bytes.u32()?;
                if !self.is_the_products(self.subject.dictionary.row(slot)?.id()) {
                    return Some(Step::Advance { us: u64::from(raw % 2_000) });
                }
                Step::Set { slot, raw }
            }
            19 => bytes.pick(&[
                Step::Emergency { code: 0x1000 },
                Step::Emergency { code: 0xFF01 },
                Step::Overrun,
                Step::Supervise(BusState::Active),
                Step::Supervise(BusState::Active),
                Step::Supervise(BusState::Warning),
                Step::Supervise(BusState::Passive),
                Step::Supervise(BusState::Off),
                Step::Trigger { number: 0 },
                Step::Trigger { number: 1 },
            ])?,
            20 => Step::Errors { register: bytes.u8()? & bytes.u8()? },
            21 => Step::Advance { us: u64::from(bytes.u8()?).pow(2) * 4 },
            22 => Step::Mood(bytes.pick(&[
                Mood::Willing,
                Mood::Willing,
                Mood::Willing,
                Mood::Deaf,
                Mood::Refusing(WriteError::Hardware),
                Mood::Refusing(WriteError::NotStored),
                Mood::Unreadable(ReadError::NoData),
            ])?),
            _ => bytes.pick(&[
                Step::GiveBack,
                Step::Bus(Bus::Busy),
                Step::Bus(Bus::Free),
                Step::Bus(Bus::Free),
                Step::Stored(Ok(())),
                Step::Stored(Err(WriteError::NotStored)),
            ])?,
        };
        Some(step)
    }

    /// What partners of a node say, the time for which they say nothing, and the user.
    fn sign_of_life(&self, bytes: &mut Bytes<'_>) -> Option<Step> {
        let own = ERROR_CONTROL + u16::from(self.subject.node_id.get());
        let kind = bytes.u8()?;
        let step = match kind % 16 {
            _ if kind >= 224 => Step::Hurry,
            0..=4 => Step::Receive(Frame::new_remote(CanId::new(own)?, bytes.u8()? % 9)?),
            5..=8 => {
                let any = 1 + bytes.u8()? % 127;
                let producers = self.monitored().map(|(producer, _)| producer);
                let producer = bytes.pick(&producers.chain([any]).collect::<Vec<_>>())?;
                let id = CanId::new(ERROR_CONTROL + u16::from(producer))?;
                let data = bytes.pick(&[&[0][..], &[5], &[0x7F], &[4], &[], &[5, 5]])?;
                Step::Receive(Frame::new(id, data)?)
            }
            9 | 10 => {
                let time = [bytes.array()?, bytes.array::<4>()?].concat();
                let len = bytes.pick(&[6, 6, 6, 0, 5, 7, 8])?;
                let cob_id = self.value(TIME).unwrap_or(0x100);
                Step::Receive(Frame::new(CanId::new((cob_id & 0x7FF) as u16)?, &time[..len])?)
            }
            11 | 12 => Step::Advance { us: self.span(bytes)? },
            13 => match (self.span(bytes)?, self.step(bytes.u8()? % 17, bytes)?) {
                (us, Step::Receive(frame)) => Step::ReceiveAfter { us, frame },
                (us, _) => Step::Sleep { us },
            },
            14 => Step::Touch,
            _ => self.kept(bytes)?,
        };
        Some(step)
    }

    /// A value that another version of the program may have left.
    fn kept(&self, bytes: &mut Bytes<'_>) -> Option<Step> {
        let dictionary = self.subject.dictionary;
        let slot = Slot::at(dictionary, bytes.u16()? % LEN as u16)?;
        let row = dictionary.row(slot)?;
        let small = u32::from(bytes.u8()?);
        let mapped = Slot::at(dictionary, small as u16 % LEN as u16)?;
        let ObjectId { index, sub } = dictionary.row(mapped)?.id();
        let bits = bytes.pick(&[8, 8, 16, 32, 0, 4, 64, 255])?;
        let entry = u32::from(index) << 16 | u32::from(sub) << 8 | bits;
        let any = bytes.u32()?;
        let raw = row.data_type().widen(bytes.pick(&[small, small % 10, entry, entry, any])?);
        let is_kept = !is_text(row.data_type()) && row.permits(raw) && may_be_kept(row.id(), raw);
        Some(if is_kept { Step::Keep { slot, raw } } else { Step::Advance { us: 1 } })
    }

    /// Up to half an hour, which is how late a call may be.
    fn span(&self, bytes: &mut Bytes<'_>) -> Option<u64> {
        Some(u64::from(bytes.u32()? >> (bytes.u8()? % 32)) % 1_800_000_000)
    }

    /// A request for an object that mostly exists, with a value that is mostly small.
    fn sdo_request(&self, bytes: &mut Bytes<'_>) -> Option<Vec<u8>> {
        let any = bytes.u8()?;
        let command = bytes.pick(&[
            0x40, 0x40, 0x22, 0x23, 0x23, 0x2B, 0x2F, 0x21, 0x20, 0x60, 0x70, 0xA0, 0xA4, 0xA1,
            0xA2, 0xA3, 0xC2, 0xC6, 0xC1, 0x00, 0x01, any, any,
        ])?;
        let mut rows = self.subject.dictionary.rows();
        let len = rows.len();
        let object = match bytes.u16()? {
            other @ 0xF000.. => ObjectId { index: 0x1000 + (other & 0xFFF), sub: any },
            known => rows.nth(usize::from(known) % len)?.id(),
        };
        let (small, now) = (u32::from(bytes.u8()?), self.value(object).unwrap_or(0));
        let value = match bytes.u8()? % 8 {
            0..=3 if object.index == 0x1010 => u32::from_le_bytes(*b"save"),
            0..=3 if object.index == 0x1011 => u32::from_le_bytes(*b"load"),
            0..=2 => small,
            3 => small << 16 | u32::from(any),
            4 => now,
            5 => now ^ 1 << 31,
            6 => now ^ 1 << (small % 32),
            _ => bytes.u32()?,
        };
        let [low, high] = object.index.to_le_bytes();
        let mut data = vec![command, low, high, object.sub];
        data.extend(value.to_le_bytes());
        data.truncate(if any % 16 == 1 { (small % 9) as usize } else { 8 });
        Some(data)
    }

    /// Objects of the stack itself are not the product's to set.
    const fn is_the_products(&self, object: ObjectId) -> bool {
        object.index >= 0x2000
    }
}

/// Errors are not, and identifiers that are have been checked when a master wrote them. No version
/// received objects of the stack itself.
const fn may_be_kept(object: ObjectId, raw: u32) -> bool {
    match object.index {
        0x1001 | 0x1003 | 0x1005 | 0x1012 | 0x1014 => false,
        0x1400..=0x15FF | 0x1800..=0x19FF => object.sub != 1,
        0x1600..=0x17FF => object.sub == 0 || raw >= 0x2000_0000,
        _ => true,
    }
}
