//! A device with what DEV1 lacks: guarding beside block transfer, limits, a command, an output that only
//! receive PDOs carry, and a say in what a communication error brings about.

use object_dictionary::{Number, Object, PdoMapping, Value};

const fn ro<T: Number>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name)
}

const fn rw<T: Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name).read_write()
}

const DEVICE_TYPE: Object<u32> = ro(0x1000, 0, "Device type").default(0x0003_0191);
const ERROR_REGISTER: Object<u8> = ro(0x1001, 0, "Error register");
const ERROR_COUNT: Object<u8> = rw(0x1003, 0, "Errors");
const ERROR_1: Object<u32> = ro(0x1003, 1, "Error");
const ERROR_2: Object<u32> = ro(0x1003, 2, "Error");
const SYNC_COB_ID: Object<u32> = rw(0x1005, 0, "COB-ID SYNC").default(0x80);
const CYCLE_PERIOD: Object<u32> = rw(0x1006, 0, "Communication cycle period");
const NAME: Object<[u8; 12]> = Object::new(0x1008, 0, "Name").default_text("whole device");
const GUARD_TIME: Object<u16> = rw(0x100C, 0, "Guard time");
const LIFE_TIME_FACTOR: Object<u8> = rw(0x100D, 0, "Life time factor");
const STORE_COUNT: Object<u8> = Object::highest_sub_index(0x1010, "Store", 2);
const STORE_1: Object<u32> = rw(0x1010, 1, "Store").default(1);
const STORE_2: Object<u32> = rw(0x1010, 2, "Store").default(1);
const RESTORE_COUNT: Object<u8> = Object::highest_sub_index(0x1011, "Restore", 2);
const RESTORE_1: Object<u32> = rw(0x1011, 1, "Restore").default(1);
const RESTORE_2: Object<u32> = rw(0x1011, 2, "Restore").default(1);
const EMCY_COB_ID: Object<u32> = rw(0x1014, 0, "COB-ID EMCY").default_node_id_plus(0x80);
const CONSUMER_COUNT: Object<u8> = Object::highest_sub_index(0x1016, "Monitored nodes", 2);
const CONSUMER_1: Object<u32> = rw(0x1016, 1, "Monitored node");
const CONSUMER_2: Object<u32> = rw(0x1016, 2, "Monitored node");
const HEARTBEAT: Object<u16> = rw(0x1017, 0, "Heartbeat time");
const IDENTITY_COUNT: Object<u8> = Object::highest_sub_index(0x1018, "Identity", 4);
const VENDOR: Object<u32> = ro(0x1018, 1, "Vendor");
const PRODUCT: Object<u32> = ro(0x1018, 2, "Product");
const REVISION: Object<u32> = ro(0x1018, 3, "Revision");
const SERIAL: Object<u32> = ro(0x1018, 4, "Serial number");
const SYNC_COUNTER: Object<u8> = rw(0x1019, 0, "SYNC counter");
const BEHAVIOUR_COUNT: Object<u8> = Object::highest_sub_index(0x1029, "Error behaviour", 1);
const BEHAVIOUR: Object<u8> = rw(0x1029, 1, "Error behaviour").within(0, 2);
const SDO_COUNT: Object<u8> = Object::highest_sub_index(0x1200, "SDO server", 2);
const SDO_REQUEST: Object<u32> = ro(0x1200, 1, "SDO request").default_node_id_plus(0x600);
const SDO_RESPONSE: Object<u32> = ro(0x1200, 2, "SDO response").default_node_id_plus(0x580);
const RPDO_COUNT: Object<u8> = Object::highest_sub_index(0x1400, "RPDO", 5);
const RPDO_COB_ID: Object<u32> = rw(0x1400, 1, "RPDO").default_node_id_plus(0x200);
const RPDO_TYPE: Object<u8> = rw(0x1400, 2, "RPDO").default(255);
const RPDO_TIMER: Object<u16> = rw(0x1400, 5, "RPDO");
const RPDO_MAP_COUNT: Object<u8> = rw(0x1600, 0, "RPDO mapping").default(1);
const RPDO_MAP_1: Object<u32> = rw(0x1600, 1, "RPDO mapping").default(0x6200_0108);
const RPDO_MAP_2: Object<u32> = rw(0x1600, 2, "RPDO mapping");
const TPDO_COUNT: Object<u8> = Object::highest_sub_index(0x1800, "TPDO", 6);
const TPDO_COB_ID: Object<u32> = rw(0x1800, 1, "TPDO").default_node_id_plus(0x4000_0180);
const TPDO_TYPE: Object<u8> = rw(0x1800, 2, "TPDO").default(255);
const TPDO_INHIBIT: Object<u16> = rw(0x1800, 3, "TPDO");
const TPDO_TIMER: Object<u16> = rw(0x1800, 5, "TPDO");
const TPDO_SYNC_START: Object<u8> = rw(0x1800, 6, "TPDO");
const TPDO_MAP_COUNT: Object<u8> = rw(0x1A00, 0, "TPDO mapping").default(1);
const TPDO_MAP_1: Object<u32> = rw(0x1A00, 1, "TPDO mapping").default(0x6000_0120);
const TPDO_MAP_2: Object<u32> = rw(0x1A00, 2, "TPDO mapping");
const TPDO_MAP_3: Object<u32> = rw(0x1A00, 3, "TPDO mapping");
const LIMITED: Object<u16> =
    rw(0x2001, 0, "Limited").stored_on_command().within(1, 1_000).default(10);
const SIGNED: Object<i8> = rw(0x2002, 0, "Signed").stored_on_command().within(-100, 100);
const COMMAND: Object<u8> = Object::new(0x2003, 0, "Command").write_only();
const INPUT_COUNT: Object<u8> = Object::highest_sub_index(0x6000, "Inputs", 2);
const INPUT_1: Object<u32> = ro(0x6000, 1, "Input").mappable(PdoMapping::Transmit);
const INPUT_2: Object<u32> = ro(0x6000, 2, "Input").mappable(PdoMapping::Transmit);
const INPUT_STRUCTURE: Object<u32> = ro(0x6000, 255, "Structure of the inputs").default(0x0708);
const OUTPUT_COUNT: Object<u8> = Object::highest_sub_index(0x6200, "Outputs", 2);
const OUTPUT_1: Object<u8> = rw(0x6200, 1, "Output").mappable(PdoMapping::Receive);
const OUTPUT_2: Object<u8> = rw(0x6200, 2, "Output that is read back").mappable(PdoMapping::Both);

object_dictionary::product! {
    pub(crate)
    DEVICE_TYPE, ERROR_REGISTER, ERROR_COUNT, ERROR_1, ERROR_2, SYNC_COB_ID, CYCLE_PERIOD, NAME,
    GUARD_TIME, LIFE_TIME_FACTOR, STORE_COUNT, STORE_1, STORE_2, RESTORE_COUNT, RESTORE_1, RESTORE_2,
    EMCY_COB_ID, CONSUMER_COUNT, CONSUMER_1, CONSUMER_2, HEARTBEAT, IDENTITY_COUNT, VENDOR, PRODUCT,
    REVISION, SERIAL, SYNC_COUNTER, BEHAVIOUR_COUNT, BEHAVIOUR, SDO_COUNT, SDO_REQUEST, SDO_RESPONSE,
    RPDO_COUNT, RPDO_COB_ID, RPDO_TYPE, RPDO_TIMER, RPDO_MAP_COUNT, RPDO_MAP_1, RPDO_MAP_2,
    TPDO_COUNT, TPDO_COB_ID, TPDO_TYPE, TPDO_INHIBIT, TPDO_TIMER, TPDO_SYNC_START, TPDO_MAP_COUNT,
    TPDO_MAP_1, TPDO_MAP_2, TPDO_MAP_3, LIMITED, SIGNED, COMMAND, INPUT_COUNT, INPUT_1, INPUT_2,
    INPUT_STRUCTURE, OUTPUT_COUNT, OUTPUT_1, OUTPUT_2,
}
