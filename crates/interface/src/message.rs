//! The text for the display, object 0x2007 (NM17x DISP-17, DISP-19, A-102).

use profiles::nm17x::between_controllers::{MESSAGE_END, MESSAGE_PARTS};

use crate::link::{Kind, Link, QueueError};

const LEN: usize = 12;

/// The last text of a master, and whether the application controller shows it.
#[derive(Debug, Default)]
pub(crate) struct Message {
    text: Option<[u8; LEN]>,
    shown: bool,
}

impl Message {
    /// The text, if there was one since the start.
    pub(crate) fn text(&self) -> Option<&[u8]> {
        self.text.as_ref().map(<[u8; LEN]>::as_slice)
    }

    /// Takes a text for which the queue has room.
    pub(crate) fn set(&mut self, link: &Link, text: &[u8]) -> Result<(), QueueError> {
        link.check_room(MESSAGE_PARTS.len())?;
        self.text = text.try_into().ok();
        Ok(())
    }

    /// Has the text shown. Nothing has taken its room since it was set.
    pub(crate) fn show(&mut self, link: &mut Link) {
        let (parts, _) = self.text().unwrap_or_default().as_chunks::<4>();
        for (id, part) in MESSAGE_PARTS.into_iter().zip(parts) {
            let _ = link.write(id, u32::from_le_bytes(*part), Kind::Value);
        }
        self.shown = true;
    }

    /// The application controller took another write, which ends the text.
    pub(crate) fn note_write(&mut self) {
        self.shown = false;
    }

    /// A write that the application controller does not see ends the text. Without room in the
    /// queue the next one does.
    pub(crate) fn end(&mut self, link: &mut Link) {
        if self.shown && link.write(MESSAGE_END, 0, Kind::Value).is_ok() {
            self.shown = false;
        }
    }
}
