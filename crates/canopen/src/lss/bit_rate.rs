/// A bit rate of the standard table, table selector 0 (CiA 305, section 3.9.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitRate {
    /// 1000 kbit/s.
    Kbit1000,
    /// 800 kbit/s.
    Kbit800,
    /// 500 kbit/s.
    Kbit500,
    /// 250 kbit/s.
    Kbit250,
    /// 125 kbit/s.
    Kbit125,
    /// 100 kbit/s; a reserved index in newer issues of CiA 305.
    Kbit100,
    /// 50 kbit/s.
    Kbit50,
    /// 20 kbit/s.
    Kbit20,
    /// 10 kbit/s.
    Kbit10,
}

impl BitRate {
    /// All of the table, in its order.
    pub const ALL: &'static [Self] = &[
        Self::Kbit1000,
        Self::Kbit800,
        Self::Kbit500,
        Self::Kbit250,
        Self::Kbit125,
        Self::Kbit100,
        Self::Kbit50,
        Self::Kbit20,
        Self::Kbit10,
    ];

    /// The rate at a table index. `None` for automatic detection (9) and above.
    #[must_use]
    pub fn from_index(index: u8) -> Option<Self> {
        Self::ALL.get(usize::from(index)).copied()
    }

    /// The index in the table, 0 to 8.
    #[must_use]
    pub const fn index(self) -> u8 {
        self as u8
    }

    /// The rate in kbit/s.
    #[must_use]
    pub const fn kbit_per_s(self) -> u16 {
        match self {
            Self::Kbit1000 => 1_000,
            Self::Kbit800 => 800,
            Self::Kbit500 => 500,
            Self::Kbit250 => 250,
            Self::Kbit125 => 125,
            Self::Kbit100 => 100,
            Self::Kbit50 => 50,
            Self::Kbit20 => 20,
            Self::Kbit10 => 10,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x LSS-05.
    #[test]
    fn the_table_is_in_order_and_ends_at_8() {
        for (index, kbit_per_s) in (0..).zip([1_000, 800, 500, 250, 125, 100, 50, 20, 10]) {
            let rate = BitRate::from_index(index).unwrap();
            assert_eq!((rate.index(), rate.kbit_per_s()), (index, kbit_per_s));
        }
        assert_eq!(BitRate::from_index(9), None);
    }
}
