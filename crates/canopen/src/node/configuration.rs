//! What written values bring about: services take their objects over, and PDOs become due.

use object_dictionary::{ObjectId, Slot};

use super::Node;
use crate::acceptance::Screen;
use crate::emcy;
use crate::guarding;
use crate::heartbeat;
use crate::nmt::State;
use crate::parameter::number;
use crate::settings::ProductSettings;
use crate::sync;
use crate::time;

const HEARTBEAT_TIME: u16 = 0x1017;

impl<S: ProductSettings, const LEN: usize> Node<LEN, S> {
    /// Takes all values over that services follow, as if they had been written. A service reads all
    /// of its objects at once, and so do PDOs; only monitored producers have an entry each.
    pub(super) fn configure(&mut self) {
        for (slot, row) in self.values.dictionary().slots() {
            if row.id().sub <= 1 || row.id().index == heartbeat::CONSUMER_TIME {
                self.note_change(slot);
            }
        }
        (self.has_news, self.filters_changed) = (false, false);
    }

    /// Acts on a changed value: on the stack's own objects at once, on mapped ones by marking their
    /// PDOs.
    pub(super) fn note_change(&mut self, slot: Slot) {
        self.note_value(slot);
        match self.values.dictionary().row(slot) {
            Some(row) if row.id().index < 0x2000 => self.follow_parameter(row.id()),
            Some(_) | None => {}
        }
    }

    /// Marks the PDOs that follow a changed value.
    pub(super) fn note_value(&mut self, slot: Slot) {
        if self.tpdos.may_follow(slot) {
            self.tpdos.note_change(slot);
            self.wake_for_pdos();
        }
    }

    /// Acts on what a master wrote, if that has not been done.
    #[inline(never)]
    pub(super) fn follow_master(&mut self) {
        if let Some(slot) = self.configured.take() {
            self.note_change(slot);
        }
    }

    #[inline(never)]
    fn follow_parameter(&mut self, object: ObjectId) {
        match object.index {
            sync::COB_ID | sync::PERIOD | sync::WINDOW | sync::OVERFLOW => self.reread_sync(),
            time::COB_ID => {
                self.time = time::consumed(&self.values);
                self.change_filters();
            }
            guarding::GUARD_TIME | guarding::LIFE_TIME_FACTOR => {
                self.guarded.reread(&self.values);
                self.update_error_register();
            }
            HEARTBEAT_TIME => {
                self.heartbeat.set_period_ms(number(&self.values, HEARTBEAT_TIME, 0));
                if self.heartbeat.is_on() {
                    self.guarded.stop();
                    self.update_error_register();
                }
                match self.state {
                    State::Initialising => {}
                    State::PreOperational | State::Operational | State::Stopped => {
                        self.heartbeat.restart(self.now.into());
                    }
                }
            }
            heartbeat::CONSUMER_TIME => {
                if self.monitored.reread(object.sub, &self.values) {
                    self.change_filters();
                }
                self.update_error_register();
            }
            emcy::COB_ID | emcy::INHIBIT_TIME => {
                self.emergencies.reread(self.now.into(), &self.values);
            }
            index @ 0x1400..=0x17FF => self.reread_rpdo(index),
            index @ 0x1800..=0x1BFF => self.reread_tpdo(index),
            _ => {}
        }
        self.schedule();
    }

    fn reread_sync(&mut self) {
        let before = self.sync.id();
        self.sync.reread(&self.values);
        if self.state.serves_sdo() {
            self.sync.start(self.now.into());
        }
        if self.sync.id() != before {
            self.change_filters();
        }
    }

    fn reread_rpdo(&mut self, index: u16) {
        if self.rpdos.reread(index, &self.values) {
            self.change_filters();
        }
    }

    fn reread_tpdo(&mut self, index: u16) {
        let rules = &self.settings().pdo;
        if self.tpdos.reread(self.now.into(), index, &self.values, rules) {
            self.change_filters();
        }
        if self.state == State::Operational {
            self.tpdos.start(self.now.into());
        }
    }

    fn change_filters(&mut self) {
        (self.has_news, self.filters_changed) = (true, true);
        match self.state {
            State::Initialising => {}
            State::PreOperational | State::Operational | State::Stopped => self.listen(),
        }
    }

    pub(super) fn listen(&mut self) {
        let mut screen = Screen::CLOSED;
        self.accepts().for_each(|accepted| screen.open(accepted.id));
        self.screen = screen;
    }
}
