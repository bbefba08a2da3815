//! What errors bring about: the error register, emergency messages and the error behaviour.

use object_dictionary::ObjectId;

use super::{Event, Node};
use crate::deadline::Deadline;
use crate::emcy;
use crate::nmt::{ERROR_BEHAVIOUR, State};
use crate::parameter::parameter;
use crate::settings::{Emergency, ErrorBehaviour, ProductSettings};

const ERROR_REGISTER: ObjectId = ObjectId { index: emcy::ERROR_REGISTER, sub: 0 };

/// Error register: any error, and one of the communication.
const COMMUNICATION_ERROR: u8 = 1 << 4 | 1;
/// Error register: an error of the maker's own.
const MANUFACTURER_ERROR: u32 = 1 << 7;

/// What 0x1029 distinguishes.
#[derive(Clone, Copy, Debug)]
pub(super) enum ErrorClass {
    Communication,
    Manufacturer,
}

impl<S: ProductSettings, const LEN: usize> Node<LEN, S> {
    pub(super) fn say(&mut self, emergency: Option<Emergency>) {
        if let Some(emergency) = emergency {
            self.raise(self.state, emergency);
        }
    }

    /// Each producer that is missing is an event, a message and a reason to act.
    pub(super) fn give_up_producers(&mut self) {
        while let Some(producer) = self.monitored.take_due(self.now.into()) {
            self.report(Event::HeartbeatLost { producer });
            self.lose_partner();
        }
    }

    pub(super) fn give_up_master(&mut self) {
        if self.guarded.take_due(self.now.into()) {
            self.report(Event::GuardingLost);
            self.lose_partner();
        }
    }

    /// The message is older than the state that follows, and is sent even if that has none.
    fn lose_partner(&mut self) {
        self.update_error_register();
        let state = self.state;
        self.react(ErrorClass::Communication);
        self.raise(state, emcy::PARTNER_LOST);
    }

    pub(super) fn update_error_register(&mut self) {
        let Ok(slot) = self.values.dictionary().find(ERROR_REGISTER) else { return };
        let disturbed =
            self.guarded.is_lost() || self.monitored.is_any_lost() || self.bus.is_impaired();
        let own = if disturbed { COMMUNICATION_ERROR } else { 0 };
        let (before, after) = (self.values.raw(slot), u32::from(self.device_errors | own));
        self.change_value(slot, after);
        if before != 0 && after == 0 {
            self.raise(self.state, emcy::ERROR_RESET);
        }
        if !before & after & MANUFACTURER_ERROR != 0 {
            self.react(ErrorClass::Manufacturer);
        }
    }

    /// Does what 0x1029 says (CiA 301, section 7.5.2.32). Without an entry a communication error
    /// ends Operational, and other errors change nothing.
    pub(super) fn react(&mut self, class: ErrorClass) {
        const TO_PRE_OPERATIONAL: u32 = 0;
        const NO_CHANGE: u32 = 1;
        const TO_STOPPED: u32 = 2;
        const RESET: u32 = 3;
        let acts = match self.settings().error_behaviour {
            ErrorBehaviour::InOperational => self.state == State::Operational,
            ErrorBehaviour::InEveryState => self.state != State::Initialising,
        };
        let (sub, absent) = match class {
            ErrorClass::Communication => (1, TO_PRE_OPERATIONAL),
            ErrorClass::Manufacturer => (2, NO_CHANGE),
        };
        match parameter(&self.values, ERROR_BEHAVIOUR, sub).unwrap_or(absent) {
            TO_PRE_OPERATIONAL if self.state == State::Operational => {
                self.enter(State::PreOperational);
            }
            TO_STOPPED if acts => self.enter(State::Stopped),
            RESET if acts => self.leave(Event::ResetNode),
            _ => {}
        }
    }

    /// Takes an error that came in `state`, if that has emergency messages.
    #[inline(never)]
    pub(super) fn raise(&mut self, state: State, emergency: Emergency) {
        if !state.serves_sdo() {
            return;
        }
        let settings = self.settings();
        self.emergencies.raise(emergency, &mut self.values, settings);
        if self.emergencies.is_uninhibited() && self.state != State::Initialising {
            self.send_due_emergencies();
        }
        self.wake_by(self.emergency_due_at());
    }

    /// Messages that were held back go out in the states that have emergency messages.
    pub(super) fn send_waiting_emergencies(&mut self) {
        self.emergencies.end_inhibit_time(self.now.into());
        if self.state.serves_sdo() {
            self.send_due_emergencies();
        }
    }

    #[inline(never)]
    fn send_due_emergencies(&mut self) {
        while let Some(frame) = self.emergencies.take(self.now.into()) {
            self.outbox.push_once(frame);
        }
    }

    pub(super) fn emergency_due_at(&self) -> Deadline {
        if self.state.serves_sdo() {
            self.emergencies.due_at(self.now.into())
        } else {
            self.emergencies.inhibited_until()
        }
    }
}
