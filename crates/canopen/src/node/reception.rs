//! What received frames bring about.

use super::{Event, Node};
use crate::application::Application;
use crate::cob_id::{self, Service};
use crate::frame::{CanId, Frame};
use crate::nmt::{Command, State};
use crate::pdo::Target;
use crate::sdo::{Effect, Objects};
use crate::settings::ProductSettings;
use crate::sync;
use crate::time::TimeOfDay;

impl<S: ProductSettings, const LEN: usize> Node<LEN, S> {
    /// Hands a frame to who listens to it, the frequent ones first. The handlers are functions of
    /// their own: none pays for the registers and the stack of another.
    #[inline]
    pub(super) fn dispatch(&mut self, frame: &Frame, application: &mut impl Application) {
        let id = frame.id();
        if frame.is_remote() {
            self.handle_remote(id);
        } else if id == Service::SdoRequest.id(self.node_id) {
            self.handle_sdo(frame, application);
        } else if id == self.sync.id() {
            self.handle_sync(frame, application);
        } else {
            self.handle_rpdo(frame, application);
        }
    }

    /// Acts on what a master wrote, before the frame that came too early for it.
    #[inline(never)]
    pub(super) fn catch_up(&mut self, frame: &Frame, application: &mut impl Application) {
        self.follow_master();
        self.handle_frame(self.now, frame, application);
    }

    #[inline(never)]
    fn handle_rare(&mut self, frame: &Frame) {
        let id = frame.id();
        if id == cob_id::NMT {
            self.handle_nmt(frame);
        } else if Service::ErrorControl.has(id) {
            self.handle_heartbeat(frame);
        } else if self.time == id {
            self.handle_time(frame);
        } else if let Some(slave) = &mut self.lss {
            let reaction = slave.handle_frame(frame);
            self.follow(reaction);
        }
    }

    fn handle_nmt(&mut self, frame: &Frame) {
        match Command::parse(frame.data(), self.node_id) {
            Some(Command::Enter(state)) => {
                self.enter(state);
                self.send_waiting_emergencies();
                self.transmit_due();
                self.schedule();
            }
            Some(Command::ResetNode) => self.leave(Event::ResetNode),
            Some(Command::ResetCommunication) => self.leave(Event::ResetCommunication),
            None => {}
        }
    }

    fn handle_heartbeat(&mut self, frame: &Frame) {
        if frame.dlc() != 1 {
            return;
        }
        if let Some(producer) = self.monitored.handle(self.now.into(), frame.id()) {
            self.report(Event::HeartbeatRecovered { producer });
            self.update_error_register();
        }
        self.wake_by(self.monitored.due_at(self.now.into()));
    }

    fn handle_time(&mut self, frame: &Frame) {
        if self.state.serves_sdo()
            && let Some(time) = TimeOfDay::parse(frame)
        {
            self.report(Event::Time(time));
        }
    }

    #[inline(never)]
    fn handle_remote(&mut self, id: CanId) {
        if id == Service::ErrorControl.id(self.node_id) {
            self.handle_guarding();
        } else {
            self.tpdos.handle_remote(self.now.into(), id, &self.values, &mut self.outbox);
            self.wake_for_pdos();
        }
    }

    /// Heartbeats go before guarding (CiA 301, section 7.2.8.2.2). A node that is not up has no
    /// identifier to be guarded by.
    fn handle_guarding(&mut self) {
        let is_up = self.state != State::Initialising;
        if !is_up || !self.guarded.is_served() || self.heartbeat.is_on() {
            return;
        }
        let recovered = self.guarded.handle(self.now.into());
        let answer = self.guarded.answer(self.state.heartbeat_byte());
        self.wake_by(self.guarded.due_at());
        self.send_error_control(answer);
        if recovered {
            self.report(Event::GuardingRecovered);
            self.update_error_register();
        }
    }

    #[inline(never)]
    fn handle_sdo(&mut self, frame: &Frame, application: &mut impl Application) {
        if !self.state.serves_sdo() {
            return;
        }
        let waited = self.sdo.is_waiting();
        let Self { values, monitored, settings, state, .. } = self;
        let mut objects = Objects::new(values, application, monitored, *settings, *state);
        self.sdo.handle(self.now.into(), frame, &mut objects);
        let effect = objects.effect();
        self.answer();
        if waited || self.sdo.is_waiting() {
            if self.sdo.is_sending_block() {
                self.send_segment();
            }
            self.wake_at = self.now;
        }
        match effect {
            Effect::None => {}
            Effect::Changed(slot) => self.note_value(slot),
            Effect::Configured(slot) => {
                self.configured = Some(slot);
                self.wake_at = self.now;
            }
            Effect::Store { sub } => self.report(Event::Store { sub }),
            Effect::Restore { sub } => self.report(Event::Restore { sub }),
        }
    }

    /// What waited for the SYNC is taken over before PDOs go out with it.
    #[inline(never)]
    pub(super) fn handle_sync(&mut self, frame: &Frame, application: &mut impl Application) {
        let counter = match self.sync.receive(frame) {
            sync::Received::Sync { counter } => counter,
            sync::Received::UnexpectedLength => {
                return self.say(self.settings().receive_errors.sync_length);
            }
            sync::Received::Nothing => return,
        };
        if self.state != State::Operational {
            return;
        }
        if self.rpdos.wait() {
            self.take_over_waiting(application);
        }
        self.tpdos.handle_sync(counter, &self.values, &mut self.outbox);
        if let Some(window_ends_at) = self.sync.open_window(self.now.into()) {
            self.wake_by(window_ends_at);
        }
    }

    #[inline(never)]
    fn take_over_waiting(&mut self, application: &mut impl Application) {
        let Self { values, tpdos, rpdos, .. } = self;
        rpdos.handle_sync(&mut Target { values, tpdos, application, is_late: false });
        self.follow_values();
    }

    #[inline(never)]
    fn handle_rpdo(&mut self, frame: &Frame, application: &mut impl Application) {
        if self.state != State::Operational {
            return self.handle_rare(frame);
        }
        let Self { values, tpdos, rpdos, .. } = self;
        let target =
            &mut Target { values, tpdos, application, is_late: self.sync.is_window_over() };
        let Some(outcome) = rpdos.handle_frame(self.now.into(), frame, target) else {
            return self.handle_rare(frame);
        };
        if let Some(fault) = outcome.fault {
            self.say(fault.emergency(&self.settings().receive_errors));
        }
        if outcome.goes_on {
            self.follow_values();
        }
    }
}
