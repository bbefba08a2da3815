use super::bit_rate::BitRate;

/// What products do differently with layer setting services, as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How long a request has to be.
    pub request_length: RequestLength,
    /// In which states a switch selective counts.
    pub selection: Selection,
    /// What a device says that was selected.
    pub selected: Selected,
    /// Whether all devices of the vendor can be told to show offers.
    pub addressing: Addressing,
    /// Whether the identify services and fastscan are answered.
    pub identification: Identification,
    /// Whether the node-ID can be taken away again.
    pub unconfigured: Unconfigured,
    /// The bit rates the device can be set to.
    pub bit_rates: &'static [BitRate],
}

/// How long a request has to be; longer and shorter ones change nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestLength {
    /// Eight bytes.
    Eight,
    /// As many bytes as the service needs, or more.
    AsNeeded,
}

/// In which states a switch selective counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selection {
    /// In waiting only; a device in configuration ignores it.
    WhileWaiting,
    /// In waiting and in configuration: a device that is not meant returns to waiting, so that a
    /// selection after a global switch leaves one device in configuration.
    WhileWaitingOrConfiguring,
}

/// What a device says that was selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selected {
    /// That it was.
    Confirmed,
    /// The number of its mode as well, 1 for configuration.
    Mode,
}

/// Whether all devices of the vendor can be told to show offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addressing {
    /// Node-IDs are configured in configuration only.
    Configured,
    /// A switch selective with the own vendor-ID and 0xFFFFFFFF for the rest puts all devices into
    /// addressing: they show the node-ID that is offered, and the one that is touched takes it.
    ConfiguredOrOffered,
}

/// Whether the identify services and fastscan are answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identification {
    /// As CiA 305 has it.
    Answered,
    /// They are not known to the product.
    Ignored,
}

/// Whether the node-ID can be taken away again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unconfigured {
    /// Node-ID 255 is one to configure: the device is without after the next reset.
    Permitted,
    /// Node-ID 255 is out of range.
    OutOfRange,
}

impl Settings {
    /// As CiA 305 has it.
    pub const CIA_305: Self = Self {
        request_length: RequestLength::Eight,
        selection: Selection::WhileWaiting,
        selected: Selected::Confirmed,
        addressing: Addressing::Configured,
        identification: Identification::Answered,
        unconfigured: Unconfigured::Permitted,
        bit_rates: BitRate::ALL,
    };
}
