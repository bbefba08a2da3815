//! DEV1: a device with one of everything, to judge stacks by. It has a text, a block of 64 bytes,
//! two PDOs each way with two objects of 32 bits and eight of 8 bits, and every object of CiA 301
//! that they need.
//!
//! The same device is what other stacks were measured with, so that figures and the answers of a
//! conformance test can be compared.
#![no_std]

use canopen::{
    Application, BlockTransfer, Node, NodeId, ProductSettings, Settings, WriteError, lss,
};
use object_dictionary::{Number, Object, PdoMapping, Row, Slot, Value};

/// Its node-ID.
pub const NODE_ID: NodeId = NodeId::new(0x10).expect("16 is a node-ID");

/// As CiA 301 has it, with all that is optional. Its one bit rate cannot be set.
pub static SETTINGS: Settings = Settings {
    lss: Some(&lss::Settings { bit_rates: &[], ..lss::Settings::CIA_305 }),
    ..Settings::CIA_301
};

/// [`SETTINGS`], known to the compiler wherever they are used.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn;

impl ProductSettings for BuiltIn {
    #[inline]
    fn settings(self) -> &'static Settings {
        &SETTINGS
    }
}

/// Bytes of the block, 0x2000.
pub const BLOB_LEN: usize = 64;

const fn ro<T: Number>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name)
}

const fn rw<T: Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name).read_write()
}

const DEVICE_TYPE: Object<u32> = ro(0x1000, 0, "Device type").default(0x0003_0191);
const ERROR_REGISTER: Object<u8> = ro(0x1001, 0, "Error register");
const ERROR_COUNT: Object<u8> = rw(0x1003, 0, "Pre-defined error field");
const ERROR_1: Object<u32> = ro(0x1003, 1, "Pre-defined error field");
const ERROR_2: Object<u32> = ro(0x1003, 2, "Pre-defined error field");
const ERROR_3: Object<u32> = ro(0x1003, 3, "Pre-defined error field");
const ERROR_4: Object<u32> = ro(0x1003, 4, "Pre-defined error field");
const ERROR_5: Object<u32> = ro(0x1003, 5, "Pre-defined error field");
const ERROR_6: Object<u32> = ro(0x1003, 6, "Pre-defined error field");
const ERROR_7: Object<u32> = ro(0x1003, 7, "Pre-defined error field");
const ERROR_8: Object<u32> = ro(0x1003, 8, "Pre-defined error field");
const SYNC_COB_ID: Object<u32> = rw(0x1005, 0, "COB-ID SYNC message").default(0x80);
const CYCLE_PERIOD: Object<u32> = rw(0x1006, 0, "Communication cycle period");
const SYNC_WINDOW: Object<u32> = rw(0x1007, 0, "Synchronous window length");
const NAME: Object<[u8; 16]> =
    Object::new(0x1008, 0, "Manufacturer device name").default_text("bench device one");
const STORE_COUNT: Object<u8> = Object::highest_sub_index(0x1010, "Store parameters", 4);
const STORE_1: Object<u32> = rw(0x1010, 1, "Store parameters").default(1);
const STORE_2: Object<u32> = rw(0x1010, 2, "Store parameters").default(1);
const STORE_3: Object<u32> = rw(0x1010, 3, "Store parameters").default(1);
const STORE_4: Object<u32> = rw(0x1010, 4, "Store parameters").default(1);
const RESTORE_COUNT: Object<u8> =
    Object::highest_sub_index(0x1011, "Restore default parameters", 4);
const RESTORE_1: Object<u32> = rw(0x1011, 1, "Restore default parameters").default(1);
const RESTORE_2: Object<u32> = rw(0x1011, 2, "Restore default parameters").default(1);
const RESTORE_3: Object<u32> = rw(0x1011, 3, "Restore default parameters").default(1);
const RESTORE_4: Object<u32> = rw(0x1011, 4, "Restore default parameters").default(1);
const EMCY_COB_ID: Object<u32> = rw(0x1014, 0, "COB-ID EMCY").default_node_id_plus(0x80);
const EMCY_INHIBIT: Object<u16> = rw(0x1015, 0, "Inhibit time EMCY");
const CONSUMER_COUNT: Object<u8> = Object::highest_sub_index(0x1016, "Consumer heartbeat time", 4);
const CONSUMER_1: Object<u32> = rw(0x1016, 1, "Consumer heartbeat time");
const CONSUMER_2: Object<u32> = rw(0x1016, 2, "Consumer heartbeat time");
const CONSUMER_3: Object<u32> = rw(0x1016, 3, "Consumer heartbeat time");
const CONSUMER_4: Object<u32> = rw(0x1016, 4, "Consumer heartbeat time");
const HEARTBEAT: Object<u16> = rw(0x1017, 0, "Producer heartbeat time").default(1_000);
const IDENTITY_COUNT: Object<u8> = Object::highest_sub_index(0x1018, "Identity object", 4);
const VENDOR: Object<u32> = ro(0x1018, 1, "Identity object").default(0x1234);
const PRODUCT: Object<u32> = ro(0x1018, 2, "Identity object").default(2);
const REVISION: Object<u32> = ro(0x1018, 3, "Identity object").default(3);
const SERIAL: Object<u32> = ro(0x1018, 4, "Identity object").default(4);
const SYNC_COUNTER: Object<u8> = rw(0x1019, 0, "Synchronous counter overflow value");
const SDO_COUNT: Object<u8> = Object::highest_sub_index(0x1200, "SDO server parameter", 2);
const SDO_REQUEST: Object<u32> = ro(0x1200, 1, "SDO server parameter").default_node_id_plus(0x600);
const SDO_RESPONSE: Object<u32> = ro(0x1200, 2, "SDO server parameter").default_node_id_plus(0x580);
const RPDO1_COUNT: Object<u8> =
    Object::highest_sub_index(0x1400, "RPDO communication parameter", 5);
const RPDO1_COB_ID: Object<u32> =
    rw(0x1400, 1, "RPDO communication parameter").default_node_id_plus(0x200);
const RPDO1_TYPE: Object<u8> = rw(0x1400, 2, "RPDO communication parameter").default(254);
const RPDO1_TIMER: Object<u16> = rw(0x1400, 5, "RPDO communication parameter");
const RPDO2_COUNT: Object<u8> =
    Object::highest_sub_index(0x1401, "RPDO communication parameter", 5);
const RPDO2_COB_ID: Object<u32> =
    rw(0x1401, 1, "RPDO communication parameter").default_node_id_plus(0x300);
const RPDO2_TYPE: Object<u8> = rw(0x1401, 2, "RPDO communication parameter").default(254);
const RPDO2_TIMER: Object<u16> = rw(0x1401, 5, "RPDO communication parameter");
const RPDO1_MAP_COUNT: Object<u8> = rw(0x1600, 0, "RPDO mapping parameter").default(2);
const RPDO1_MAP_1: Object<u32> = rw(0x1600, 1, "RPDO mapping parameter").default(0x6200_0120);
const RPDO1_MAP_2: Object<u32> = rw(0x1600, 2, "RPDO mapping parameter").default(0x6200_0220);
const RPDO1_MAP_3: Object<u32> = rw(0x1600, 3, "RPDO mapping parameter");
const RPDO1_MAP_4: Object<u32> = rw(0x1600, 4, "RPDO mapping parameter");
const RPDO1_MAP_5: Object<u32> = rw(0x1600, 5, "RPDO mapping parameter");
const RPDO1_MAP_6: Object<u32> = rw(0x1600, 6, "RPDO mapping parameter");
const RPDO1_MAP_7: Object<u32> = rw(0x1600, 7, "RPDO mapping parameter");
const RPDO1_MAP_8: Object<u32> = rw(0x1600, 8, "RPDO mapping parameter");
const RPDO2_MAP_COUNT: Object<u8> = rw(0x1601, 0, "RPDO mapping parameter").default(8);
const RPDO2_MAP_1: Object<u32> = rw(0x1601, 1, "RPDO mapping parameter").default(0x6201_0108);
const RPDO2_MAP_2: Object<u32> = rw(0x1601, 2, "RPDO mapping parameter").default(0x6201_0208);
const RPDO2_MAP_3: Object<u32> = rw(0x1601, 3, "RPDO mapping parameter").default(0x6201_0308);
const RPDO2_MAP_4: Object<u32> = rw(0x1601, 4, "RPDO mapping parameter").default(0x6201_0408);
const RPDO2_MAP_5: Object<u32> = rw(0x1601, 5, "RPDO mapping parameter").default(0x6201_0508);
const RPDO2_MAP_6: Object<u32> = rw(0x1601, 6, "RPDO mapping parameter").default(0x6201_0608);
const RPDO2_MAP_7: Object<u32> = rw(0x1601, 7, "RPDO mapping parameter").default(0x6201_0708);
const RPDO2_MAP_8: Object<u32> = rw(0x1601, 8, "RPDO mapping parameter").default(0x6201_0808);
const TPDO1_COUNT: Object<u8> =
    Object::highest_sub_index(0x1800, "TPDO communication parameter", 6);
const TPDO1_COB_ID: Object<u32> =
    rw(0x1800, 1, "TPDO communication parameter").default_node_id_plus(0x4000_0180);
const TPDO1_TYPE: Object<u8> = rw(0x1800, 2, "TPDO communication parameter").default(1);
const TPDO1_INHIBIT: Object<u16> = rw(0x1800, 3, "TPDO communication parameter");
const TPDO1_TIMER: Object<u16> = rw(0x1800, 5, "TPDO communication parameter");
const TPDO1_SYNC_START: Object<u8> = rw(0x1800, 6, "TPDO communication parameter");
const TPDO2_COUNT: Object<u8> =
    Object::highest_sub_index(0x1801, "TPDO communication parameter", 6);
const TPDO2_COB_ID: Object<u32> =
    rw(0x1801, 1, "TPDO communication parameter").default_node_id_plus(0x4000_0280);
const TPDO2_TYPE: Object<u8> = rw(0x1801, 2, "TPDO communication parameter").default(254);
const TPDO2_INHIBIT: Object<u16> = rw(0x1801, 3, "TPDO communication parameter");
const TPDO2_TIMER: Object<u16> = rw(0x1801, 5, "TPDO communication parameter");
const TPDO2_SYNC_START: Object<u8> = rw(0x1801, 6, "TPDO communication parameter");
const TPDO1_MAP_COUNT: Object<u8> = rw(0x1A00, 0, "TPDO mapping parameter").default(2);
const TPDO1_MAP_1: Object<u32> = rw(0x1A00, 1, "TPDO mapping parameter").default(0x6000_0120);
const TPDO1_MAP_2: Object<u32> = rw(0x1A00, 2, "TPDO mapping parameter").default(0x6000_0220);
const TPDO1_MAP_3: Object<u32> = rw(0x1A00, 3, "TPDO mapping parameter");
const TPDO1_MAP_4: Object<u32> = rw(0x1A00, 4, "TPDO mapping parameter");
const TPDO1_MAP_5: Object<u32> = rw(0x1A00, 5, "TPDO mapping parameter");
const TPDO1_MAP_6: Object<u32> = rw(0x1A00, 6, "TPDO mapping parameter");
const TPDO1_MAP_7: Object<u32> = rw(0x1A00, 7, "TPDO mapping parameter");
const TPDO1_MAP_8: Object<u32> = rw(0x1A00, 8, "TPDO mapping parameter");
const TPDO2_MAP_COUNT: Object<u8> = rw(0x1A01, 0, "TPDO mapping parameter").default(8);
const TPDO2_MAP_1: Object<u32> = rw(0x1A01, 1, "TPDO mapping parameter").default(0x6001_0108);
const TPDO2_MAP_2: Object<u32> = rw(0x1A01, 2, "TPDO mapping parameter").default(0x6001_0208);
const TPDO2_MAP_3: Object<u32> = rw(0x1A01, 3, "TPDO mapping parameter").default(0x6001_0308);
const TPDO2_MAP_4: Object<u32> = rw(0x1A01, 4, "TPDO mapping parameter").default(0x6001_0408);
const TPDO2_MAP_5: Object<u32> = rw(0x1A01, 5, "TPDO mapping parameter").default(0x6001_0508);
const TPDO2_MAP_6: Object<u32> = rw(0x1A01, 6, "TPDO mapping parameter").default(0x6001_0608);
const TPDO2_MAP_7: Object<u32> = rw(0x1A01, 7, "TPDO mapping parameter").default(0x6001_0708);
const TPDO2_MAP_8: Object<u32> = rw(0x1A01, 8, "TPDO mapping parameter").default(0x6001_0808);
/// 64 bytes that the device keeps ([`Device`]).
pub const BLOB: Object<[u8; BLOB_LEN]> = rw(0x2000, 0, "Configuration");
const IN32_COUNT: Object<u8> = Object::highest_sub_index(0x6000, "Inputs of 32 bits", 4);
const IN32_1: Object<u32> = ro(0x6000, 1, "Inputs of 32 bits").mappable(PdoMapping::Transmit);
const IN32_2: Object<u32> = ro(0x6000, 2, "Inputs of 32 bits").mappable(PdoMapping::Transmit);
const IN32_3: Object<u32> = ro(0x6000, 3, "Inputs of 32 bits").mappable(PdoMapping::Transmit);
const IN32_4: Object<u32> = ro(0x6000, 4, "Inputs of 32 bits").mappable(PdoMapping::Transmit);
const IN8_COUNT: Object<u8> = Object::highest_sub_index(0x6001, "Inputs of 8 bits", 8);
const IN8_1: Object<u8> = ro(0x6001, 1, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_2: Object<u8> = ro(0x6001, 2, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_3: Object<u8> = ro(0x6001, 3, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_4: Object<u8> = ro(0x6001, 4, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_5: Object<u8> = ro(0x6001, 5, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_6: Object<u8> = ro(0x6001, 6, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_7: Object<u8> = ro(0x6001, 7, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const IN8_8: Object<u8> = ro(0x6001, 8, "Inputs of 8 bits").mappable(PdoMapping::Transmit);
const OUT32_COUNT: Object<u8> = Object::highest_sub_index(0x6200, "Outputs of 32 bits", 4);
const OUT32_1: Object<u32> = rw(0x6200, 1, "Outputs of 32 bits").mappable(PdoMapping::Both);
const OUT32_2: Object<u32> = rw(0x6200, 2, "Outputs of 32 bits").mappable(PdoMapping::Both);
const OUT32_3: Object<u32> = rw(0x6200, 3, "Outputs of 32 bits").mappable(PdoMapping::Both);
const OUT32_4: Object<u32> = rw(0x6200, 4, "Outputs of 32 bits").mappable(PdoMapping::Both);
const OUT8_COUNT: Object<u8> = Object::highest_sub_index(0x6201, "Outputs of 8 bits", 8);
const OUT8_1: Object<u8> = rw(0x6201, 1, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_2: Object<u8> = rw(0x6201, 2, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_3: Object<u8> = rw(0x6201, 3, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_4: Object<u8> = rw(0x6201, 4, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_5: Object<u8> = rw(0x6201, 5, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_6: Object<u8> = rw(0x6201, 6, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_7: Object<u8> = rw(0x6201, 7, "Outputs of 8 bits").mappable(PdoMapping::Both);
const OUT8_8: Object<u8> = rw(0x6201, 8, "Outputs of 8 bits").mappable(PdoMapping::Both);

object_dictionary::product! {
    pub
    DEVICE_TYPE, ERROR_REGISTER, ERROR_COUNT, ERROR_1, ERROR_2, ERROR_3, ERROR_4, ERROR_5,
    ERROR_6, ERROR_7, ERROR_8, SYNC_COB_ID, CYCLE_PERIOD, SYNC_WINDOW, NAME, STORE_COUNT,
    STORE_1, STORE_2, STORE_3, STORE_4, RESTORE_COUNT, RESTORE_1, RESTORE_2, RESTORE_3,
    RESTORE_4, EMCY_COB_ID, EMCY_INHIBIT, CONSUMER_COUNT, CONSUMER_1, CONSUMER_2,
    CONSUMER_3, CONSUMER_4, HEARTBEAT, IDENTITY_COUNT, VENDOR, PRODUCT, REVISION, SERIAL,
    SYNC_COUNTER, SDO_COUNT, SDO_REQUEST, SDO_RESPONSE, RPDO1_COUNT, RPDO1_COB_ID,
    RPDO1_TYPE, RPDO1_TIMER, RPDO2_COUNT, RPDO2_COB_ID, RPDO2_TYPE, RPDO2_TIMER,
    RPDO1_MAP_COUNT, RPDO1_MAP_1, RPDO1_MAP_2, RPDO1_MAP_3, RPDO1_MAP_4, RPDO1_MAP_5,
    RPDO1_MAP_6, RPDO1_MAP_7, RPDO1_MAP_8, RPDO2_MAP_COUNT, RPDO2_MAP_1, RPDO2_MAP_2,
    RPDO2_MAP_3, RPDO2_MAP_4, RPDO2_MAP_5, RPDO2_MAP_6, RPDO2_MAP_7, RPDO2_MAP_8,
    TPDO1_COUNT, TPDO1_COB_ID, TPDO1_TYPE, TPDO1_INHIBIT, TPDO1_TIMER, TPDO1_SYNC_START,
    TPDO2_COUNT, TPDO2_COB_ID, TPDO2_TYPE, TPDO2_INHIBIT, TPDO2_TIMER, TPDO2_SYNC_START,
    TPDO1_MAP_COUNT, TPDO1_MAP_1, TPDO1_MAP_2, TPDO1_MAP_3, TPDO1_MAP_4, TPDO1_MAP_5,
    TPDO1_MAP_6, TPDO1_MAP_7, TPDO1_MAP_8, TPDO2_MAP_COUNT, TPDO2_MAP_1, TPDO2_MAP_2,
    TPDO2_MAP_3, TPDO2_MAP_4, TPDO2_MAP_5, TPDO2_MAP_6, TPDO2_MAP_7, TPDO2_MAP_8, BLOB,
    IN32_COUNT, IN32_1, IN32_2, IN32_3, IN32_4, IN8_COUNT, IN8_1, IN8_2, IN8_3, IN8_4,
    IN8_5, IN8_6, IN8_7, IN8_8, OUT32_COUNT, OUT32_1, OUT32_2, OUT32_3, OUT32_4,
    OUT8_COUNT, OUT8_1, OUT8_2, OUT8_3, OUT8_4, OUT8_5, OUT8_6, OUT8_7, OUT8_8,
}

/// The device with everything but its node-ID as at delivery, before its boot-up message.
#[must_use]
pub fn node(node_id: NodeId) -> Node<LEN, BuiltIn> {
    Node::new(&DICTIONARY, node_id, BuiltIn)
}

/// What stands behind the dictionary: the block of bytes.
#[derive(Clone, Copy, Debug)]
pub struct Device {
    blob: [u8; BLOB_LEN],
}

impl Device {
    /// At delivery: all bytes are zero.
    #[must_use]
    pub const fn new() -> Self {
        Self { blob: [0; BLOB_LEN] }
    }
}

impl Default for Device {
    fn default() -> Self {
        Self::new()
    }
}

impl Application for Device {
    const BLOCK_TRANSFER: BlockTransfer = BlockTransfer::Served;

    fn text(&self, _slot: Slot, row: &Row) -> Option<&[u8]> {
        (row.id() == BLOB.id()).then_some(&self.blob)
    }

    fn write_text(&mut self, _slot: Slot, _row: &Row, text: &[u8]) -> Result<(), WriteError> {
        self.blob = text.try_into().map_err(|_| WriteError::Failed)?;
        Ok(())
    }
}
