use crate::cob_id::NodeId;

/// Which state errors lead to.
pub(crate) const ERROR_BEHAVIOUR: u16 = 0x1029;

/// The states of the network management (CiA 301, section 7.3.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Not on the bus: before the boot-up message and after a reset command.
    Initialising,
    /// SDO only.
    PreOperational,
    /// SDO and PDO.
    Operational,
    /// Neither; only the network management and the error control.
    Stopped,
}

impl State {
    /// The state as the heartbeat names it.
    pub(crate) const fn heartbeat_byte(self) -> u8 {
        match self {
            Self::Initialising => 0x00,
            Self::Stopped => 0x04,
            Self::Operational => 0x05,
            Self::PreOperational => 0x7F,
        }
    }

    /// Whether SDO requests are served.
    pub(crate) const fn serves_sdo(self) -> bool {
        match self {
            Self::PreOperational | Self::Operational => true,
            Self::Initialising | Self::Stopped => false,
        }
    }
}

/// What a network manager asks for (CiA 301, section 7.2.8.2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    Enter(State),
    ResetNode,
    ResetCommunication,
}

impl Command {
    /// The command, if the bytes are one for this node: exactly a command and a node-ID, which is
    /// its own or 0 for all nodes.
    pub(crate) fn parse(data: &[u8], node_id: NodeId) -> Option<Self> {
        const ALL_NODES: u8 = 0;
        let &[command, addressed] = data else { return None };
        if addressed != ALL_NODES && addressed != node_id.get() {
            return None;
        }
        match command {
            0x01 => Some(Self::Enter(State::Operational)),
            0x02 => Some(Self::Enter(State::Stopped)),
            0x80 => Some(Self::Enter(State::PreOperational)),
            0x81 => Some(Self::ResetNode),
            0x82 => Some(Self::ResetCommunication),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x NMT-01, NMT-02.
    #[test]
    fn only_whole_commands_for_this_node_count() {
        let node_id = NodeId::new(0x7F).unwrap();
        for (data, expected) in [
            (&[0x01, 0x7F][..], Some(Command::Enter(State::Operational))),
            (&[0x02, 0x00], Some(Command::Enter(State::Stopped))),
            (&[0x80, 0x7F], Some(Command::Enter(State::PreOperational))),
            (&[0x81, 0x00], Some(Command::ResetNode)),
            (&[0x82, 0x7F], Some(Command::ResetCommunication)),
            (&[0x01, 0x01], None),
            (&[0x03, 0x7F], None),
            (&[0x01], None),
            (&[0x01, 0x7F, 0x00], None),
            (&[], None),
        ] {
            assert_eq!(Command::parse(data, node_id), expected, "{data:02X?}");
        }
    }
}
