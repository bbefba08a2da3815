use object_dictionary::{Dictionary, Text};

use crate::{ap04, encoder, nm170, nm172, nm174};

/// What the generated files say of a product.
#[derive(Debug)]
pub struct Sheet {
    /// Name of its EDS file, without the ending.
    pub file: &'static str,
    /// Who sells it.
    pub vendor: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// Bit rates in kbit/s.
    pub bit_rates: &'static [u16],
    /// Whether it can be addressed without a node-ID.
    pub lss: Lss,
    /// All objects.
    pub dictionary: &'static Dictionary,
    /// Their names, in the same order.
    pub texts: &'static [Text],
}

/// Layer setting services (CiA 305).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lss {
    /// The product does not have them.
    None,
    /// The product is a slave.
    Slave,
}

const BAUMER: &str = "Baumer";
const SIKO: &str = "SIKO GmbH";
const CIA_305_AND_100: &[u16] = &[10, 20, 50, 100, 125, 250, 500, 800, 1000];

/// Every product with a CAN bus.
pub static SHEETS: &[Sheet] = &[
    Sheet {
        file: "NM170",
        vendor: BAUMER,
        name: "NM170 Standard",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &nm170::DICTIONARY,
        texts: nm170::TEXTS,
    },
    Sheet {
        file: "NM172",
        vendor: BAUMER,
        name: "NM172 Standard",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &nm172::DICTIONARY,
        texts: nm172::TEXTS,
    },
    Sheet {
        file: "NM174",
        vendor: BAUMER,
        name: "NM174 Standard",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &nm174::DICTIONARY,
        texts: nm174::TEXTS,
    },
    Sheet {
        file: "AP04",
        vendor: SIKO,
        name: "AP04",
        bit_rates: &[125, 250, 500, 1000],
        lss: Lss::None,
        dictionary: &ap04::DICTIONARY,
        texts: ap04::TEXTS,
    },
    Sheet {
        file: "GXMMW_H",
        vendor: BAUMER,
        name: "GXMM multivo multiturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gxmm::DICTIONARY,
        texts: encoder::gxmm::TEXTS,
    },
    Sheet {
        file: "GXAMW_H",
        vendor: BAUMER,
        name: "GXAM multivo singleturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gxam::DICTIONARY,
        texts: encoder::gxam::TEXTS,
    },
    Sheet {
        file: "GCMMW_H",
        vendor: BAUMER,
        name: "GCMM magtivo multiturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gcmm::DICTIONARY,
        texts: encoder::gcmm::TEXTS,
    },
    Sheet {
        file: "GCAMW_H",
        vendor: BAUMER,
        name: "GCAM magtivo singleturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gcam::DICTIONARY,
        texts: encoder::gcam::TEXTS,
    },
    Sheet {
        file: "GBMMW_H",
        vendor: BAUMER,
        name: "GBMM multivoPlus multiturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gbmm::DICTIONARY,
        texts: encoder::gbmm::TEXTS,
    },
    Sheet {
        file: "GBAMW_H",
        vendor: BAUMER,
        name: "GBAM multivoPlus singleturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gbam::DICTIONARY,
        texts: encoder::gbam::TEXTS,
    },
    Sheet {
        file: "GDMM",
        vendor: BAUMER,
        name: "GDMM activo multiturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gdmm::DICTIONARY,
        texts: encoder::gdmm::TEXTS,
    },
    Sheet {
        file: "GDAM",
        vendor: BAUMER,
        name: "GDAM activo singleturn",
        bit_rates: CIA_305_AND_100,
        lss: Lss::Slave,
        dictionary: &encoder::gdam::DICTIONARY,
        texts: encoder::gdam::TEXTS,
    },
];
