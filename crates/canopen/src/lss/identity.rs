/// What tells one device from every other: the identity object (0x1018:01 to 04).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The vendor-ID that CiA gave out.
    pub vendor_id: u32,
    /// The product code.
    pub product_code: u32,
    /// The revision number.
    pub revision: u32,
    /// The serial number, unique among devices of one product and revision.
    pub serial: u32,
}

/// A part of the identity, in the order of the identity object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Vendor,
    Product,
    Revision,
    Serial,
}

impl Part {
    const ALL: [Self; 4] = [Self::Vendor, Self::Product, Self::Revision, Self::Serial];

    /// The part with this number, 0 to 3.
    pub(super) fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    pub(super) const fn number(self) -> u8 {
        self as u8
    }
}

impl Identity {
    pub(super) const fn part(&self, part: Part) -> u32 {
        match part {
            Part::Vendor => self.vendor_id,
            Part::Product => self.product_code,
            Part::Revision => self.revision,
            Part::Serial => self.serial,
        }
    }

    pub(super) const fn set_part(&mut self, part: Part, value: u32) {
        match part {
            Part::Vendor => self.vendor_id = value,
            Part::Product => self.product_code = value,
            Part::Revision => self.revision = value,
            Part::Serial => self.serial = value,
        }
    }
}
