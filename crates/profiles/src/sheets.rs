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

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use object_dictionary::{Access, Default, ObjectId, Owner, PdoMapping, Row};

    use super::*;

    /// Its sub-index 0 counts the errors it holds: none at delivery.
    const ERROR_LIST: u16 = 0x1003;

    fn rows() -> impl Iterator<Item = (&'static Sheet, Row)> {
        SHEETS.iter().flat_map(|sheet| sheet.dictionary.rows().map(move |row| (sheet, row)))
    }

    fn number(row: Row) -> Option<u32> {
        match row.default() {
            Default::Number(number) => Some(number),
            Default::NodeIdPlus(_) | Default::Text(_) => None,
        }
    }

    /// NM17x GEN-07: one controller holds what belongs to the bus, the other what is measured, shown
    /// and driven.
    #[test]
    fn an_index_decides_who_holds_an_object() {
        const LAYER_SETTINGS: [u16; 2] = [0x2100, 0x2101];
        const PDO_CONTENTS: [u16; 2] = [0x2500, 0x2501];
        for product in [&nm170::PRODUCT, &nm172::PRODUCT, &nm174::PRODUCT] {
            for row in product.dictionary.rows() {
                let ObjectId { index, sub } = row.id();
                let of_the_bus = index < 0x2000
                    || LAYER_SETTINGS.contains(&index)
                    || PDO_CONTENTS.contains(&index) && sub > 0;
                let owner = if of_the_bus { Owner::Interface } else { Owner::Application };
                assert_eq!(row.owner(), owner, "{}: {:?}", product.slug, row.id());
            }
        }
    }

    /// CiA 301, PDO mapping: index, sub-index and length of what a PDO carries. The NM170 names the
    /// status of the other types although it has none (NM17x A-37).
    #[test]
    fn pdos_carry_objects_that_exist_and_may_be_carried() {
        for (sheet, row) in rows().filter(|(_, row)| row.id().sub > 0) {
            let way = match row.id().index {
                0x1600..=0x17FF => PdoMapping::Receive,
                0x1A00..=0x1BFF => PdoMapping::Transmit,
                _ => continue,
            };
            let entry = number(row).unwrap_or(0);
            let [high, low, sub, bits] = entry.to_be_bytes();
            let id = ObjectId { index: u16::from_be_bytes([high, low]), sub };
            let carried =
                sheet.dictionary.find(id).ok().and_then(|slot| sheet.dictionary.row(slot));
            let Some(carried) = carried else {
                assert_eq!((sheet.file, id.index), ("NM170", 0x204E), "{:?}", row.id());
                continue;
            };
            assert_eq!(carried.data_type().len() * 8, usize::from(bits), "{} {id:?}", sheet.file);
            assert!([way, PdoMapping::Both].contains(&carried.pdo()), "{} {id:?}", sheet.file);
        }
    }

    /// CiA 301, records and arrays: sub-index 0 is the highest sub-index. The NM170 says 8 for its
    /// single setpoint, as the other types do (NM17x A-38), and TxPDO2 of the AP04 says 5 although
    /// sub-indices 3 to 5 are unused.
    #[test]
    fn sub_index_0_is_the_highest_sub_index() {
        for sheet in SHEETS {
            let rows: Vec<Row> = sheet.dictionary.rows().collect();
            for object in rows.chunk_by(|a, b| a.id().index == b.id().index) {
                let [first, .., last] = object else { continue };
                let expected = match (sheet.file, first.id().index) {
                    (_, ERROR_LIST) => 0,
                    ("NM170", 0x2020) => 8,
                    ("AP04", 0x1801) => 5,
                    _ => u32::from(last.id().sub),
                };
                assert_eq!(number(*first), Some(expected), "{} {:?}", sheet.file, first.id());
            }
        }
    }

    #[test]
    fn every_object_has_a_name_of_its_own() {
        for sheet in SHEETS {
            for (n, text) in sheet.texts.iter().enumerate() {
                let same = |other: &&Text| other.name == text.name;
                assert!(!text.name.is_empty(), "{} {n}", sheet.file);
                assert_eq!(
                    sheet.texts.iter().filter(same).count(),
                    1,
                    "{} {}",
                    sheet.file,
                    text.name
                );
            }
        }
    }

    /// What can only be written has no value that could be stored.
    #[test]
    fn commands_are_not_stored() {
        for (sheet, row) in rows().filter(|(_, row)| row.access() == Access::WriteOnly) {
            let volatile = row.storage() == object_dictionary::Storage::Volatile;
            assert!(volatile, "{} {:?}", sheet.file, row.id());
        }
    }
}
