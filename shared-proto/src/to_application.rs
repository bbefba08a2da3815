use serde::{Deserialize, Serialize};

use crate::Hello;

/// From the CAN interface controller. Append only: postcard encodes the position of a variant, so
/// reordering or removing one breaks devices in the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToApplication {
    /// Start, restart or loss of either side.
    Hello(Hello),
    /// Nothing to command in this gap.
    Idle(Supervision),
    /// Write an object. Acknowledged by [`ProcessData::acknowledged`](crate::ProcessData).
    Write(Supervision, Write),
    /// Send all values from this position of the dictionary to its end.
    RequestSnapshot {
        /// State of the node.
        supervision: Supervision,
        /// Position of the first wanted row.
        from: u16,
    },
    /// Stop. Overtakes everything, sent again every cycle until
    /// [`ProcessData::urgent_acknowledged`](crate::ProcessData) carries its number.
    Urgent(Supervision, Urgent),
}

/// What the application controller is told in every gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Supervision {
    /// NMT state of the node.
    pub state: NodeState,
    /// Node-ID in use, 1 to 127.
    pub node_id: u8,
}

/// NMT states of CiA 301 as the application controller needs them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NodeState {
    /// Before the boot-up message.
    Initialising,
    /// Pre-operational.
    PreOperational,
    /// Operational.
    Operational,
    /// Stopped.
    Stopped,
}

/// A value for an object. Values of fewer than 32 bits come in the low bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Write {
    /// 1 to 255, then 1 again. A repetition carries the same number and is executed once.
    pub sequence: u8,
    /// Index of the object.
    pub index: u16,
    /// Sub-index of the object.
    pub sub: u8,
    /// The value, two's complement.
    pub value: u32,
}

/// An order to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Urgent {
    /// 1 to 255, then 1 again.
    pub number: u8,
    /// Why.
    pub urgency: Urgency,
}

/// Why everything automatic has to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Urgency {
    /// A master stopped the motor.
    MotorStop,
    /// The node went to a lower NMT state or was reset.
    StateLowered,
    /// A monitored heartbeat is missing.
    HeartbeatLost,
    /// The CAN controller left the bus.
    BusOff,
}
