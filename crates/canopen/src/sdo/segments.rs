use super::abort::AbortCode;
use super::message::{Message, SEGMENT_LEN, segment};
use super::objects::Objects;
use super::server::Server;
use super::transfer::{Step, Transfer, going_on};
use crate::application::Application;
use crate::settings::ProductSettings;

/// The answer to a segment of the client.
const DOWNLOAD_ANSWER: u8 = 0x20;

/// Flags of a segment: it alternates, and it is the last.
const TOGGLE: u8 = 1 << 4;
const LAST: u8 = 1;

/// Values on their way in segments (CiA 301, sections 7.2.4.3.4 and 7.2.4.3.7).
impl Server {
    /// The client asks for the next segment.
    pub(super) fn upload_segment(&mut self, command: u8) -> Result<(), AbortCode> {
        let transfer = going_on(&mut self.transfer, Step::Upload)?;
        let rest = self.value.get(transfer.position()..).unwrap_or(&[]);
        let toggle = toggle(transfer, command)?;
        let flags = match SEGMENT_LEN.checked_sub(rest.len()) {
            Some(unused) => {
                self.transfer = None;
                let [unused, ..] = unused.to_le_bytes();
                unused << 1 | LAST
            }
            None => 0,
        };
        self.answer = Some(segment(toggle | flags, rest));
        Ok(())
    }

    /// The client has the next segment.
    pub(super) fn download_segment<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        let transfer = going_on(&mut self.transfer, Step::Download)?;
        let [command, data @ ..] = request.to_bytes();
        let answer = Message::short(DOWNLOAD_ANSWER | toggle(transfer, command)?, 0);
        let entry = transfer.entry;
        let data = data.get(..SEGMENT_LEN - usize::from(command >> 1 & 7)).unwrap_or(&[]);
        let fits = self.value.len() + data.len() <= usize::from(entry.len);
        if !fits || self.value.extend_from_slice(data).is_err() {
            return Err(objects.length_code(entry.row));
        }
        if command & LAST == 0 {
            self.answer = Some(answer);
            return Ok(());
        }
        objects.write(entry, &self.value)?;
        self.finish(entry, answer, objects)
    }
}

/// The toggle bit of the next segment, if `command` has it.
fn toggle(transfer: &mut Transfer, command: u8) -> Result<u8, AbortCode> {
    let toggle = if transfer.segments & 1 == 0 { 0 } else { TOGGLE };
    if command & TOGGLE != toggle {
        return Err(AbortCode::TOGGLE);
    }
    transfer.segments = transfer.segments.wrapping_add(1);
    Ok(toggle)
}
