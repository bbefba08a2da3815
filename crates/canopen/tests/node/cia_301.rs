//! A device with the services of CiA 301 that the NM17x do without, as CiA 301 has them.

use canopen::{Node, NodeId, Settings};
use object_dictionary::{Object, PdoMapping, Value};

pub(crate) const NODE_ID: NodeId = NodeId::new(5).expect("5 is a node-ID");

const fn rw<T: Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name).read_write()
}

const DEVICE_TYPE: Object<u32> = Object::new(0x1000, 0, "Device type");
const ERROR_REGISTER: Object<u8> = Object::new(0x1001, 0, "Error register");
const ERROR_COUNT: Object<u8> = rw(0x1003, 0, "Errors").within(0, 0);
const ERROR_1: Object<u32> = Object::new(0x1003, 1, "Error");
const ERROR_2: Object<u32> = Object::new(0x1003, 2, "Error");
const SYNC_COB_ID: Object<u32> = rw(0x1005, 0, "COB-ID SYNC").default(0x80);
const SYNC_PERIOD: Object<u32> = rw(0x1006, 0, "Communication cycle period");
const SYNC_WINDOW: Object<u32> = rw(0x1007, 0, "Synchronous window length");
const GUARD_TIME: Object<u16> = rw(0x100C, 0, "Guard time");
const LIFE_TIME_FACTOR: Object<u8> = rw(0x100D, 0, "Life time factor");
const TIME_COB_ID: Object<u32> = rw(0x1012, 0, "COB-ID TIME").default(0x8000_0100);
const EMCY_COB_ID: Object<u32> = rw(0x1014, 0, "COB-ID EMCY").default_node_id_plus(0x80);
const MONITORED: Object<u32> = rw(0x1016, 1, "Consumer heartbeat time");
const HEARTBEAT: Object<u16> = rw(0x1017, 0, "Heartbeat time");
const SYNC_OVERFLOW: Object<u8> = rw(0x1019, 0, "Synchronous counter overflow value");
const ON_COMMUNICATION_ERROR: Object<u8> = rw(0x1029, 1, "Error behaviour").default(1);
const RPDO_COB_ID: Object<u32> = rw(0x1400, 1, "COB-ID").default_node_id_plus(0x200);
const RPDO_TYPE: Object<u8> = rw(0x1400, 2, "Transmission type").default(1);
const RPDO_MAPPING: Object<u8> = Object::highest_sub_index(0x1600, "Mapping", 1);
const RPDO_MAP: Object<u32> = Object::new(0x1600, 1, "Mapping").default(0x6200_0008);
const TPDO_COB_ID: Object<u32> = rw(0x1800, 1, "COB-ID").default_node_id_plus(0x4000_0180);
const TPDO_TYPE: Object<u8> = rw(0x1800, 2, "Transmission type").default(1);
const TPDO_SYNC_START: Object<u8> = rw(0x1800, 6, "SYNC start value");
const TPDO_MAPPING: Object<u8> = Object::highest_sub_index(0x1A00, "Mapping", 1);
const TPDO_MAP: Object<u32> = Object::new(0x1A00, 1, "Mapping").default(0x6004_0020);
const POSITION: Object<i32> = Object::new(0x6004, 0, "Position").mappable(PdoMapping::Transmit);
const OUTPUT: Object<u8> = rw(0x6200, 0, "Output").mappable(PdoMapping::Receive);

object_dictionary::product! {
    pub(crate)
    DEVICE_TYPE, ERROR_REGISTER, ERROR_COUNT, ERROR_1, ERROR_2, SYNC_COB_ID, SYNC_PERIOD,
    SYNC_WINDOW, GUARD_TIME, LIFE_TIME_FACTOR, TIME_COB_ID, EMCY_COB_ID, MONITORED, HEARTBEAT,
    SYNC_OVERFLOW, ON_COMMUNICATION_ERROR, RPDO_COB_ID, RPDO_TYPE, RPDO_MAPPING, RPDO_MAP,
    TPDO_COB_ID, TPDO_TYPE, TPDO_SYNC_START, TPDO_MAPPING, TPDO_MAP, POSITION, OUTPUT,
}

/// The device, not booted yet.
pub(crate) fn node() -> Node<LEN> {
    Node::new(&DICTIONARY, NODE_ID, &Settings::CIA_301)
}
