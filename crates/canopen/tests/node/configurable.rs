//! A device whose PDOs masters may configure freely, as CiA 301 has it.

use canopen::{Node, NodeId, Settings};
use object_dictionary::{Object, PdoMapping, Value};

pub(crate) const NODE_ID: NodeId = NodeId::new(5).expect("5 is a node-ID");

const fn ro<T: Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name)
}

const fn rw<T: Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name).read_write()
}

const fn map(index: u16, sub: u8) -> Object<u32> {
    rw(index, sub, "Mapping")
}

const DEVICE_TYPE: Object<u32> = ro(0x1000, 0, "Device type");
const ERROR_REGISTER: Object<u8> = ro(0x1001, 0, "Error register");
const SYNC_COB_ID: Object<u32> = rw(0x1005, 0, "COB-ID SYNC").default(0x80);
const SYNC_OVERFLOW: Object<u8> = rw(0x1019, 0, "Synchronous counter overflow value");
const RPDO_COB_ID: Object<u32> = rw(0x1400, 1, "COB-ID").default_node_id_plus(0x200);
const RPDO_TYPE: Object<u8> = rw(0x1400, 2, "Transmission type").default(255);
const RPDO_INHIBIT: Object<u16> = rw(0x1400, 3, "Inhibit time");
const RPDO_COUNT: Object<u8> = rw(0x1600, 0, "Mapping").default(1);
const RPDO_MAP_1: Object<u32> = map(0x1600, 1).default(0x6200_0108);
const RPDO_MAP_2: Object<u32> = map(0x1600, 2);
const RPDO_MAP_3: Object<u32> = map(0x1600, 3);
const RPDO_MAP_4: Object<u32> = map(0x1600, 4);
const TPDO1_COB_ID: Object<u32> = rw(0x1800, 1, "COB-ID").default_node_id_plus(0x180);
const TPDO1_TYPE: Object<u8> = rw(0x1800, 2, "Transmission type").default(255);
const TPDO1_INHIBIT: Object<u16> = rw(0x1800, 3, "Inhibit time");
const TPDO1_TIMER: Object<u16> = rw(0x1800, 5, "Event timer");
const TPDO1_SYNC_START: Object<u8> = rw(0x1800, 6, "SYNC start value");
const TPDO2_COB_ID: Object<u32> = rw(0x1801, 1, "COB-ID").default_node_id_plus(0xC000_0280);
const TPDO2_TYPE: Object<u8> = rw(0x1801, 2, "Transmission type").default(1);
const TPDO1_COUNT: Object<u8> = rw(0x1A00, 0, "Mapping").default(2);
const TPDO1_MAP_1: Object<u32> = map(0x1A00, 1).default(0x6000_0110);
const TPDO1_MAP_2: Object<u32> = map(0x1A00, 2).default(0x6000_0208);
const TPDO1_MAP_3: Object<u32> = map(0x1A00, 3);
const TPDO1_MAP_4: Object<u32> = map(0x1A00, 4);
const TPDO1_MAP_5: Object<u32> = map(0x1A00, 5);
const TPDO1_MAP_6: Object<u32> = map(0x1A00, 6);
const TPDO1_MAP_7: Object<u32> = map(0x1A00, 7);
const TPDO1_MAP_8: Object<u32> = map(0x1A00, 8);
const TPDO2_COUNT: Object<u8> = Object::highest_sub_index(0x1A01, "Mapping", 1);
const TPDO2_MAP_1: Object<u32> = ro(0x1A01, 1, "Mapping").default(0x6000_0320);
const NOT_MAPPABLE: Object<u32> = rw(0x2000, 0, "Not mappable");
const TEXT: Object<[u8; 4]> =
    ro(0x2001, 0, "Text").default_text("text").mappable(PdoMapping::Transmit);
const INPUT_16: Object<i16> = ro(0x6000, 1, "Input").mappable(PdoMapping::Transmit);
const INPUT_8: Object<u8> = ro(0x6000, 2, "Input").mappable(PdoMapping::Transmit);
const INPUT_32: Object<u32> = ro(0x6000, 3, "Input").mappable(PdoMapping::Transmit);
const OUTPUT_8: Object<i8> = rw(0x6200, 1, "Output").mappable(PdoMapping::Receive);
const OUTPUT_16: Object<i16> = rw(0x6200, 2, "Output").mappable(PdoMapping::Both);
const OUTPUT_32: Object<u32> = rw(0x6200, 3, "Output").mappable(PdoMapping::Receive);

object_dictionary::product! {
    pub(crate)
    DEVICE_TYPE, ERROR_REGISTER, SYNC_COB_ID, SYNC_OVERFLOW, RPDO_COB_ID, RPDO_TYPE,
    RPDO_INHIBIT, RPDO_COUNT, RPDO_MAP_1, RPDO_MAP_2, RPDO_MAP_3, RPDO_MAP_4,
    TPDO1_COB_ID, TPDO1_TYPE, TPDO1_INHIBIT, TPDO1_TIMER, TPDO1_SYNC_START,
    TPDO2_COB_ID, TPDO2_TYPE,
    TPDO1_COUNT, TPDO1_MAP_1, TPDO1_MAP_2, TPDO1_MAP_3, TPDO1_MAP_4,
    TPDO1_MAP_5, TPDO1_MAP_6, TPDO1_MAP_7, TPDO1_MAP_8, TPDO2_COUNT, TPDO2_MAP_1,
    NOT_MAPPABLE, TEXT, INPUT_16, INPUT_8, INPUT_32, OUTPUT_8, OUTPUT_16, OUTPUT_32,
}

/// The device, not booted yet.
pub(crate) fn node(settings: &'static Settings) -> Node<LEN> {
    Node::new(&DICTIONARY, NODE_ID, settings)
}
