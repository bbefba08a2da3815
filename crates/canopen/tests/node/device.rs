//! A small device with an object of every kind. Plain data, so that a test binary without the
//! standard library can include it too.

use canopen::{
    AbortCode, AbortCodes, AdditionalInformation, Application, BusOff, BusRules, Emergency,
    ErrorBehaviour, Expedited, Identifiers, Mapped, Node, NodeId, PdoChanges, PdoRules, ReadError,
    ReceiveErrors, Settings, Trigger, WriteError, Written,
};
use object_dictionary::{Object, PdoMapping, Row, Slot};
use units::Duration;

/// The node-ID at delivery, 127.
pub(crate) const NODE_ID: NodeId = NodeId::new(127).expect("127 is a node-ID");

/// The choices of NM170, NM172 and NM174: decisions.
pub(crate) static SETTINGS: Settings = Settings {
    pdo: PdoRules {
        inhibit_unit: Duration::from_millis(1),
        type_254: Trigger::Timer,
        type_255: Trigger::Change,
        changes: PdoChanges::AnyTime,
        ..Settings::CIA_301.pdo
    },
    identifiers: Identifiers::Unrestricted,
    expedited: Expedited::OneTwoOrFour,
    receive_errors: ReceiveErrors {
        too_short: Some(Emergency { code: 0x8210, manufacturer: [0, 0, 0, 0, 1] }),
        too_long: None,
        value: Some(Emergency { code: 0x8220, manufacturer: [0, 0, 0, 0, 3] }),
        overdue: Some(Emergency { code: 0x8250, manufacturer: [0; 5] }),
        sync_length: None,
    },
    bus: BusRules {
        warning: Some(Emergency { code: 0x8100, manufacturer: [0; 5] }),
        passive: Some(Emergency { code: 0x8120, manufacturer: [0; 5] }),
        recovered: Some(Emergency { code: 0x8140, manufacturer: [0; 5] }),
        overrun: Some(Emergency { code: 0x8110, manufacturer: [0; 5] }),
        overflow: Some(Emergency { code: 0x8110, manufacturer: [0; 5] }),
        off: BusOff::NoReason,
    },
    error_behaviour: ErrorBehaviour::InOperational,
    additional_information: AdditionalInformation::LastByte,
    lss: None,
    abort_codes: AbortCodes {
        number_length: AbortCode::UNSUPPORTED_ACCESS,
        text_length: AbortCode::VALUE_RANGE,
        excess_bytes: Some(AbortCode::VALUE_TOO_HIGH),
        above_maximum: AbortCode::VALUE_RANGE,
        below_minimum: AbortCode::VALUE_RANGE,
        value_range: AbortCode::VALUE_RANGE,
        not_stored: AbortCode::LOCAL_CONTROL,
    },
};

const PDO_COB_IDS: &[(i64, i64)] =
    &[(0x4000_0181, 0x4000_057F), (0x8000_0181, 0x8000_057F), (0xC000_0181, 0xC000_057F)];
const ACYCLIC: &[(i64, i64)] = &[(0xFE, 0xFF)];

const fn rw<T: object_dictionary::Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name).read_write()
}

const fn live<T: object_dictionary::Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name).mappable(PdoMapping::Transmit)
}

const fn map(index: u16, sub: u8, entry: i64) -> Object<u32> {
    Object::new(index, sub, "Mapping").default(entry)
}

const fn cob_id(index: u16) -> Object<u32> {
    rw(index, 1, "COB-ID").within(0x181, 0x57F).or_within(PDO_COB_IDS)
}

const fn rpdo_cob_id(index: u16) -> Object<u32> {
    rw(index, 1, "COB-ID")
}

const fn received<T: object_dictionary::Value>(
    index: u16,
    sub: u8,
    name: &'static str,
) -> Object<T> {
    rw(index, sub, name).mappable(PdoMapping::Receive)
}

const fn transmission_type(index: u16) -> Object<u8> {
    rw(index, 2, "Transmission type").within(1, 0xF0).or_within(ACYCLIC).default(0xFF)
}

const DEVICE_TYPE: Object<u32> = Object::new(0x1000, 0, "Device type").default(0x0002_0196);
const ERROR_REGISTER: Object<u8> = Object::new(0x1001, 0, "Error register");
const ERROR_COUNT: Object<u8> = rw(0x1003, 0, "Errors").within(0, 3);
const ERROR_1: Object<u32> = Object::new(0x1003, 1, "Error");
const ERROR_2: Object<u32> = Object::new(0x1003, 2, "Error");
const ERROR_3: Object<u32> = Object::new(0x1003, 3, "Error");
const SYNC_COB_ID: Object<u32> = rw(0x1005, 0, "COB-ID SYNC").default(0x80);
const NAME: Object<[u8; 14]> = Object::new(0x1008, 0, "Name").default_text("NM172 Standard");
const HARDWARE: Object<[u8; 2]> = Object::new(0x1009, 0, "Hardware").default_text("/A");
const SOFTWARE: Object<[u8; 4]> = Object::new(0x100A, 0, "Software").default_text("1.05");
const STORE: Object<u32> = rw(0x1010, 1, "Store").default(1);
const EMCY_COB_ID: Object<u32> = rw(0x1014, 0, "COB-ID EMCY")
    .within(0x81, 0xFF)
    .or_within(&[(0x8000_0081, 0x8000_00FF)])
    .default_node_id_plus(0x80);
const EMCY_INHIBIT: Object<u16> = rw(0x1015, 0, "Inhibit time EMCY");
const MONITORED_1: Object<u32> = rw(0x1016, 1, "Consumer heartbeat time");
const MONITORED_2: Object<u32> = rw(0x1016, 2, "Consumer heartbeat time");
const ON_COMMUNICATION_ERROR: Object<u8> = rw(0x1029, 1, "Error behaviour").within(0, 2);
const ON_MANUFACTURER_ERROR: Object<u8> = rw(0x1029, 2, "Error behaviour").within(0, 2).default(1);
const HEARTBEAT: Object<u16> = rw(0x1017, 0, "Heartbeat time");
const RPDO1_COB_ID: Object<u32> = rpdo_cob_id(0x1400).default(0x4000_0201);
const RPDO1_TYPE: Object<u8> = rw(0x1400, 2, "Transmission type").default(0xFF);
const RPDO2_COB_ID: Object<u32> = rpdo_cob_id(0x1401).default_node_id_plus(0x4000_0300);
const RPDO2_TYPE: Object<u8> = rw(0x1401, 2, "Transmission type").default(0xFF);
const RPDO2_TIMER: Object<u16> = rw(0x1401, 5, "Event timer");
const RPDO3_COB_ID: Object<u32> = rpdo_cob_id(0x1402).default(0x301);
const RPDO3_TYPE: Object<u8> = rw(0x1402, 2, "Transmission type").default(0xFE);
const RPDO1_MAPPING: Object<u8> = Object::highest_sub_index(0x1600, "Mapping", 4);
const RPDO1_MAP_1: Object<u32> = map(0x1600, 1, 0x2500_0108);
const RPDO1_MAP_2: Object<u32> = map(0x1600, 2, 0x2500_0210);
const RPDO1_MAP_3: Object<u32> = map(0x1600, 3, 0x2500_0308);
const RPDO1_MAP_4: Object<u32> = map(0x1600, 4, 0x2500_0420);
const RPDO2_MAPPING: Object<u8> = Object::highest_sub_index(0x1601, "Mapping", 3);
const RPDO2_MAP_1: Object<u32> = map(0x1601, 1, 0x2501_0120);
const RPDO2_MAP_2: Object<u32> = map(0x1601, 2, 0x2501_0210);
const RPDO2_MAP_3: Object<u32> = map(0x1601, 3, 0x2501_0310);
const RPDO3_MAPPING: Object<u8> = Object::highest_sub_index(0x1602, "Mapping", 1);
const RPDO3_MAP_1: Object<u32> = map(0x1602, 1, 0x2501_0410);
const TPDO1_COB_ID: Object<u32> = cob_id(0x1800).default_node_id_plus(0xC000_0180);
const TPDO1_TYPE: Object<u8> = transmission_type(0x1800);
const TPDO1_INHIBIT: Object<u16> = rw(0x1800, 3, "Inhibit time").default(80);
const TPDO1_TIMER: Object<u16> = rw(0x1800, 5, "Event timer").default(1_000);
const TPDO2_COB_ID: Object<u32> = cob_id(0x1801).default_node_id_plus(0x4000_0280);
const TPDO2_TYPE: Object<u8> = transmission_type(0x1801);
const TPDO2_INHIBIT: Object<u16> = rw(0x1801, 3, "Inhibit time").default(80);
const TPDO2_TIMER: Object<u16> = rw(0x1801, 5, "Event timer").default(1);
const TPDO1_MAPPING: Object<u8> = Object::highest_sub_index(0x1A00, "Mapping", 3);
const TPDO1_MAP_1: Object<u32> = map(0x1A00, 1, 0x6004_0020);
const TPDO1_MAP_2: Object<u32> = map(0x1A00, 2, 0x204E_0110);
const TPDO1_MAP_3: Object<u32> = map(0x1A00, 3, 0x204E_0210);
const TPDO2_MAPPING: Object<u8> = Object::highest_sub_index(0x1A01, "Mapping", 3);
const TPDO2_MAP_1: Object<u32> = map(0x1A01, 1, 0x6004_0020);
const TPDO2_MAP_2: Object<u32> = map(0x1A01, 2, 0x2501_0410);
const TPDO2_MAP_3: Object<u32> = map(0x1A01, 3, 0x204E_0110);
const NMT_STARTUP: Object<u32> = rw(0x1F80, 0, "NMT startup").within(0, 0).or_within(&[(8, 8)]);
const ROTATE_DISPLAY: Object<u32> = rw(0x2000, 5, "Rotate display").within(0, 1);
const WINDOW: Object<u32> = rw(0x2003, 0, "Tolerance window").within(0, 9_999).default(5);
const MESSAGE: Object<[u8; 12]> = rw(0x2007, 0, "Message").default_text("1234567890AB");
const SHOW: Object<u8> = Object::new(0x2008, 0, "Show node-ID").write_only().within(0, 1);
const CUTOFF: Object<i16> = rw(0x2042, 3, "Switch-off point").within(-9_999, 9_999);
const CLAMP: Object<u8> = rw(0x2048, 0, "Clamp").within(0, 1);
const STATUS: Object<u16> = live(0x204E, 1, "Status");
const ERRORS: Object<u16> = live(0x204E, 2, "Errors");
const READING: Object<u32> = Object::new(0x2110, 0, "Sensor reading");
const NODE: Object<u8> = rw(0x2101, 0, "Node-ID").within(1, 127).default(127);
const BROADCAST_CONTROL: Object<u8> = received(0x2500, 1, "Control");
const BROADCAST_INDEX: Object<u16> = received(0x2500, 2, "Object");
const BROADCAST_SUB: Object<u8> = received(0x2500, 3, "Sub-index");
const BROADCAST_DATA: Object<u32> = received(0x2500, 4, "Data");
const SETPOINT: Object<i32> = received(0x2501, 1, "Setpoint").within(-99_999, 999_999);
const CORRECTION: Object<i16> = received(0x2501, 2, "Correction");
const CONTROL: Object<u16> = received(0x2501, 3, "Control");
const SENT_CORRECTION: Object<i16> = live(0x2501, 4, "Correction").read_write();
const PRESET: Object<i32> = rw(0x6003, 0, "Preset").within(-99_999, 999_999);
const POSITION: Object<i32> = live(0x6004, 0, "Position");

object_dictionary::product! {
    pub(crate)
    DEVICE_TYPE, ERROR_REGISTER, ERROR_COUNT, ERROR_1, ERROR_2, ERROR_3, SYNC_COB_ID, NAME,
    HARDWARE, SOFTWARE, STORE, EMCY_COB_ID, EMCY_INHIBIT, MONITORED_1, MONITORED_2, HEARTBEAT,
    ON_COMMUNICATION_ERROR, ON_MANUFACTURER_ERROR,
    RPDO1_COB_ID, RPDO1_TYPE, RPDO2_COB_ID, RPDO2_TYPE, RPDO2_TIMER, RPDO3_COB_ID, RPDO3_TYPE,
    RPDO1_MAPPING, RPDO1_MAP_1, RPDO1_MAP_2, RPDO1_MAP_3, RPDO1_MAP_4,
    RPDO2_MAPPING, RPDO2_MAP_1, RPDO2_MAP_2, RPDO2_MAP_3, RPDO3_MAPPING, RPDO3_MAP_1,
    TPDO1_COB_ID, TPDO1_TYPE, TPDO1_INHIBIT, TPDO1_TIMER,
    TPDO2_COB_ID, TPDO2_TYPE, TPDO2_INHIBIT, TPDO2_TIMER,
    TPDO1_MAPPING, TPDO1_MAP_1, TPDO1_MAP_2, TPDO1_MAP_3,
    TPDO2_MAPPING, TPDO2_MAP_1, TPDO2_MAP_2, TPDO2_MAP_3,
    NMT_STARTUP, ROTATE_DISPLAY, WINDOW, MESSAGE, SHOW, CUTOFF, CLAMP, STATUS, ERRORS, NODE,
    READING,
    BROADCAST_CONTROL, BROADCAST_INDEX, BROADCAST_SUB, BROADCAST_DATA,
    SETPOINT, CORRECTION, CONTROL, SENT_CORRECTION, PRESET, POSITION,
}

/// The node with the settings of NM17x.
pub(crate) fn node() -> Node<LEN> {
    Node::new(&DICTIONARY, NODE_ID, &SETTINGS)
}

/// What stands behind the dictionary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Device {
    message: [u8; 12],
}

impl Device {
    /// At delivery.
    pub(crate) const fn new() -> Self {
        Self { message: *b"1234567890AB" }
    }
}

impl Application for Device {
    fn read(&mut self, _slot: Slot, row: &Row) -> Result<(), ReadError> {
        if row.id() == READING.id() { Err(ReadError::NoData) } else { Ok(()) }
    }

    fn text(&self, _slot: Slot, row: &Row) -> Option<&[u8]> {
        (row.id() == MESSAGE.id()).then_some(&self.message)
    }

    fn write(&mut self, _slot: Slot, row: &Row, _raw: u32) -> Result<Written, WriteError> {
        match row.id() {
            id if id == CLAMP.id() => Err(WriteError::Hardware),
            _ => Ok(Written::Taken),
        }
    }

    fn receive(&mut self, number: u16, values: &Mapped<'_>) -> Written {
        let control = DICTIONARY.slot(&BROADCAST_CONTROL);
        match (number, values.get(control)) {
            (0, Some(0xFF)) => Written::Ignored,
            _ => Written::Taken,
        }
    }

    fn write_text(&mut self, _slot: Slot, _row: &Row, text: &[u8]) -> Result<(), WriteError> {
        self.message = text.try_into().map_err(|_| WriteError::Failed)?;
        Ok(())
    }
}
