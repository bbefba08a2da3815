use canopen::NodeId;
use canopen::lss::BitRate;

use crate::stored::Set;

/// Who waits for what is being saved. The storage says with the number of a request that this and
/// everything asked for before is saved.
#[derive(Debug, Default)]
pub(crate) struct Saving {
    last: u8,
    /// The numbers that are to be kept.
    set: Set,
    parameters: Option<Request<Parameters>>,
    layer_settings: Option<Request<LayerSettings>>,
}

#[derive(Debug)]
struct Request<T> {
    number: u8,
    subject: T,
}

/// What 0x1010 and 0x1011 ask for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Parameters {
    /// [`Saving::set`] is to be kept.
    Keep,
    /// Everything kept is to be forgotten.
    Forget,
}

/// What layer setting services ask for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerSettings {
    pub(crate) node_id: NodeId,
    pub(crate) bit_rate: Option<BitRate>,
}

impl Saving {
    /// The number of a request that has just been made: to keep these numbers.
    pub(crate) fn ask_to_keep(&mut self, set: Set) -> u8 {
        self.set = set;
        self.ask_for_parameters(Parameters::Keep)
    }

    /// The number of a request that has just been made: to forget all numbers.
    pub(crate) fn ask_to_forget(&mut self) -> u8 {
        self.ask_for_parameters(Parameters::Forget)
    }

    fn ask_for_parameters(&mut self, subject: Parameters) -> u8 {
        self.last = self.last.wrapping_add(1);
        self.parameters = Some(Request { number: self.last, subject });
        self.last
    }

    /// The number of a request that has just been made.
    pub(crate) fn ask_for_layer_settings(&mut self, subject: LayerSettings) -> u8 {
        self.last = self.last.wrapping_add(1);
        self.layer_settings = Some(Request { number: self.last, subject });
        self.last
    }

    /// The numbers to keep.
    pub(crate) const fn set(&self) -> &Set {
        &self.set
    }

    /// The request for parameters, if it is answered by this number.
    pub(crate) fn take_parameters(&mut self, number: u8) -> Option<Parameters> {
        self.parameters.take_if(|request| request.is_answered_by(number)).map(|it| it.subject)
    }

    /// The request of layer setting services, if it is answered by this number.
    pub(crate) fn take_layer_settings(&mut self, number: u8) -> Option<LayerSettings> {
        self.layer_settings.take_if(|request| request.is_answered_by(number)).map(|it| it.subject)
    }
}

impl<T> Request<T> {
    /// Fewer than half of all numbers wait at a time.
    const fn is_answered_by(&self, number: u8) -> bool {
        number.wrapping_sub(self.number) < u8::MAX / 2
    }
}
