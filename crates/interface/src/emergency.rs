//! Emergency messages of the NM17x (manual 6.1; NM17x EMCY-02, EMCY-05) and the error register
//!

use crate::link;

/// An error code with the maker's sub-code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Emergency {
    pub(crate) code: u16,
    sub_code: u8,
}

impl Emergency {
    pub(crate) const NO_BROADCAST: Self = Self::new(0x8220, 1);
    pub(crate) const PDO_NOT_QUEUED: Self = Self::new(0x8220, 2);
    pub(crate) const WRONG_VALUE: Self = Self::new(0x8220, 3);
    pub(crate) const WRONG_CONTROL_WORD: Self = Self::new(0x8230, 1);
    pub(crate) const WRITE_QUEUE_FULL: Self = Self::new(0x8301, 1);
    pub(crate) const STOP_NOT_SENT: Self = Self::new(0x8320, 2);
    pub(crate) const OFFER_NOT_SENT: Self = Self::new(0x8320, 3);
    pub(crate) const LINK_LOST: Self = Self::new(0x8310, 4);

    const fn new(code: u16, sub_code: u8) -> Self {
        Self { code, sub_code }
    }

    /// Bytes 3 to 7 of the message: the sub-code is the last one.
    pub(crate) const fn manufacturer(self) -> [u8; 5] {
        [0, 0, 0, 0, self.sub_code]
    }
}

impl From<link::Fault> for Emergency {
    fn from(fault: link::Fault) -> Self {
        match fault {
            link::Fault::ProcessDataMissing => Self::new(0x8310, 1),
            link::Fault::WriteNotAcknowledged => Self::new(0x8310, 2),
            link::Fault::CorruptValue => Self::new(0x8310, 3),
            link::Fault::Lost => Self::LINK_LOST,
            link::Fault::Mismatch => Self::new(0x8310, 5),
        }
    }
}

/// What keeps a bit of the error register set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Condition {
    /// The link is out of service.
    Link,
    /// The application has an error.
    Application,
}

/// The conditions that are present.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Conditions {
    link: bool,
    application: bool,
}

impl Conditions {
    pub(crate) const fn set(&mut self, condition: Condition, present: bool) {
        match condition {
            Condition::Link => self.link = present,
            Condition::Application => self.application = present,
        }
    }

    /// The product's part of object 0x1001: bit 0 with any condition, bit 7 application.
    pub(crate) fn error_register(self) -> u8 {
        let any = self.link || self.application;
        u8::from(any) | u8::from(self.application) << 7
    }
}
