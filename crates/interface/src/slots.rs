use object_dictionary::{Dictionary, ObjectId, Slot};
use profiles::nm17x::{
    BIT_RATE, CORRECTION, CORRECTION_ENABLED, ERRORS, NODE_ID, PDO_SETPOINT_CORRECTION_SENT,
    POSITION_VALUE, SCALING, SERIAL_NUMBER, STATUS, STATUS_REGISTER,
};

/// Where the objects are that this controller itself sets or needs: looked up once. `None`
/// for those that a product does not have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slots {
    pub(crate) position: Option<Slot>,
    pub(crate) status: Option<Slot>,
    pub(crate) errors: Option<Slot>,
    pub(crate) status_register: Option<Slot>,
    pub(crate) scaling: Option<Slot>,
    pub(crate) correction: Option<Slot>,
    pub(crate) correction_enabled: Option<Slot>,
    pub(crate) correction_sent: Option<Slot>,
    pub(crate) serial_number: Option<Slot>,
    pub(crate) bit_rate: Option<Slot>,
    pub(crate) node_id: Option<Slot>,
}

impl Slots {
    pub(crate) fn of(dictionary: &Dictionary) -> Self {
        let find = |id: ObjectId| dictionary.find(id).ok();
        Self {
            position: find(POSITION_VALUE.id()),
            status: find(STATUS.id()),
            errors: find(ERRORS.id()),
            status_register: find(STATUS_REGISTER.id()),
            scaling: find(SCALING.id()),
            correction: find(CORRECTION.id()),
            correction_enabled: find(CORRECTION_ENABLED.id()),
            correction_sent: find(PDO_SETPOINT_CORRECTION_SENT.id()),
            serial_number: find(SERIAL_NUMBER.id()),
            bit_rate: find(BIT_RATE.id()),
            node_id: find(NODE_ID.id()),
        }
    }

    /// Whether process data carry the object of the application: it is known only as long as they
    /// arrive.
    pub(crate) fn is_live(&self, slot: Slot) -> bool {
        let slot = Some(slot);
        slot == self.position || slot == self.status || slot == self.errors
    }
}
