//! What receive PDOs bring about: RxPDO1 writes one object on many devices at once, RxPDO2 is
//! setpoint, correction and control word in one (manual 4.3.4.2, 4.3.4.3).

use object_dictionary::{ObjectId, Row, Slot};
use profiles::nm17x::{
    CLAMP, COMMANDS, CORRECTION, JOG_COMMAND, LENGTH_UNIT, OSCILLATION_COMMAND,
    POSITIONING_COMMAND, PRESET, RESET_FUNCTION, SAW_IN_SPEED, SHOW_NODE_ID,
};
use shared_proto::Urgency;
use units::Instant;

use super::Interface;
use crate::control_word::Order;
use crate::emergency::Emergency;
use crate::objects::kind;

/// What RxPDO1 may write, as far as the product has it (NM17x PDO-13).
const BROADCASTS: [ObjectId; 6] = [
    LENGTH_UNIT.id(),
    SHOW_NODE_ID.id(),
    RESET_FUNCTION.id(),
    PRESET.id(),
    POSITIONING_COMMAND.id(),
    OSCILLATION_COMMAND.id(),
];
/// In the place of a correction: 0x2010 stays as it is (NM17x PDO-17).
const KEEP_CORRECTION: u16 = 0x8000;

/// The contents of a receive PDO.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Received {
    /// RxPDO1.
    Broadcast { object: u16, sub: u8, data: u32 },
    /// RxPDO2.
    Setpoint { setpoint: u32, correction: u16, control: u16 },
}

impl Interface {
    pub(super) fn follow_pdo(&mut self, now: Instant, received: Received) {
        let done = match received {
            Received::Broadcast { object, sub, data } => {
                self.broadcast(now, ObjectId { index: object, sub }, data)
            }
            Received::Setpoint { setpoint, correction, control } => {
                self.order(now, setpoint, correction, control)
            }
        };
        if let Err(emergency) = done {
            self.send(emergency);
        }
    }

    fn broadcast(&mut self, now: Instant, id: ObjectId, data: u32) -> Result<(), Emergency> {
        let (slot, row) = Some(id)
            .filter(|id| BROADCASTS.contains(id))
            .and_then(|id| self.find(id))
            .ok_or(Emergency::NO_BROADCAST)?;
        check(row, data)?;
        if id == PRESET.id() && !self.objects.has_scaling {
            return Err(Emergency::WRONG_VALUE);
        }
        if id == POSITIONING_COMMAND.id() && data == 0 {
            return self.stop();
        }
        self.check_room(1)?;
        self.forward(now, (slot, row), data);
        Ok(())
    }

    /// Every frame is executed, whatever the one before was.
    fn order(
        &mut self,
        now: Instant,
        setpoint: u32,
        correction: u16,
        control: u16,
    ) -> Result<(), Emergency> {
        let order = Order::from_control_word(control, self.product.equipment)
            .ok_or(Emergency::WRONG_CONTROL_WORD)?;
        match order {
            Order::Nothing => Ok(()),
            Order::Stop => self.stop(),
            Order::Setpoint { object, saw_in_speed } => {
                let target = self.find(object).ok_or(Emergency::WRONG_CONTROL_WORD)?;
                check(target.1, setpoint)?;
                self.check_room(3)?;
                self.correct(now, correction);
                if let Some(speed) = saw_in_speed
                    && let Some(place) = self.find(SAW_IN_SPEED.id())
                    && self.value(Some(place.0)) != speed
                {
                    self.forward(now, place, speed);
                }
                self.forward(now, target, setpoint);
                Ok(())
            }
            Order::Jog(code) => self.command(now, JOG_COMMAND.id(), code),
            Order::Clamp(code) => self.command(now, CLAMP.id(), code),
        }
    }

    fn command(&mut self, now: Instant, id: ObjectId, code: u32) -> Result<(), Emergency> {
        let place = self.find(id).ok_or(Emergency::WRONG_CONTROL_WORD)?;
        self.check_room(1)?;
        self.forward(now, place, code);
        Ok(())
    }

    /// The correction of RxPDO2 goes ahead of its setpoint, which comes into force with it.
    fn correct(&mut self, now: Instant, correction: u16) {
        self.received_correction = Some(correction);
        let value = i32::from(correction.cast_signed()).cast_unsigned();
        if correction != KEEP_CORRECTION
            && self.value(self.objects.slots.correction) != value
            && let Some(place) = self.find(CORRECTION.id())
        {
            self.forward(now, place, value);
        }
        self.follow_correction(now);
    }

    /// Hands a value for which there is room on to the application controller.
    fn forward(&mut self, now: Instant, (slot, row): (Slot, Row), raw: u32) {
        if self.objects.link.write(row.id(), raw, kind(row.id())).is_ok() {
            self.objects.message.note_write();
            if !COMMANDS.contains(&row.id()) {
                self.node.set_value(now, slot, raw);
            }
        }
    }

    fn stop(&mut self) -> Result<(), Emergency> {
        self.objects.link.check_room(0).map_err(|_| Emergency::STOP_NOT_SENT)?;
        self.objects.link.stop(Urgency::MotorStop);
        self.objects.end_message();
        Ok(())
    }

    fn check_room(&self, writes: usize) -> Result<(), Emergency> {
        self.objects.link.check_room(writes).map_err(|_| Emergency::PDO_NOT_QUEUED)
    }

    fn find(&self, id: ObjectId) -> Option<(Slot, Row)> {
        let slot = self.product.dictionary.find(id).ok()?;
        Some((slot, self.product.dictionary.row(slot)?))
    }
}

/// Bytes beyond the object's length do not count as a part of the number: they are wrong.
fn check(row: Row, raw: u32) -> Result<(), Emergency> {
    if row.data_type().widen(raw) == raw && row.permits(raw) {
        Ok(())
    } else {
        Err(Emergency::WRONG_VALUE)
    }
}
