//! Layer setting services: node-ID and bit rate over the bus, and an offer to the user (manual
//! 3.1.2, 3.1.3, 4.3.9).

use canopen::NodeId;
use canopen::lss::{Event as LssEvent, StoreError};
use profiles::nm17x::between_controllers::OFFER;
use profiles::nm17x::{BIT_RATE, NODE_ID};
use shared_proto::Urgency;
use units::Instant;

use super::{BIT_RATE_MAX, Event, Interface, NotSaved};
use crate::bit_timing::{BitTiming, Step};
use crate::emergency::Emergency;
use crate::link::Kind;
use crate::record::Record;
use crate::saving::LayerSettings;

impl Interface {
    pub(super) fn follow_lss(&mut self, now: Instant, event: LssEvent) {
        match event {
            // The NM17x always has a node-ID: none can be taken away from it.
            LssEvent::Configured { .. } | LssEvent::Store { node_id: None, .. } => {}
            LssEvent::Store { node_id: Some(node_id), bit_rate } => {
                self.save_layer_settings(LayerSettings { node_id, bit_rate });
            }
            LssEvent::StoreNodeId { node_id } => {
                self.save_layer_settings(LayerSettings { node_id, bit_rate: None });
            }
            LssEvent::ActivateBitTiming { bit_rate, delay } => {
                self.objects.link.stop(Urgency::StateLowered);
                let node_id = self.node.pending_node_id().unwrap_or(self.node.node_id());
                self.bit_timing = Some(BitTiming::new(now, bit_rate, node_id, delay));
            }
            LssEvent::Offered { node_id } => {
                self.offers = self.offers.checked_add(1).unwrap_or(1);
                self.offer = Some(self.offers);
                self.tell_offer(self.offers, node_id.get());
            }
            LssEvent::AddressingEnded => self.end_offer(),
        }
    }

    fn save_layer_settings(&mut self, settings: LayerSettings) {
        let LayerSettings { node_id, bit_rate } = settings;
        self.event(Event::Store(Record { key: NODE_ID.id().key(), value: node_id.get().into() }));
        if let Some(bit_rate) = bit_rate {
            let value = BIT_RATE_MAX.saturating_sub(bit_rate.index()).into();
            self.event(Event::Store(Record { key: BIT_RATE.id().key(), value }));
        }
        let number = self.saving.ask_for_layer_settings(settings);
        self.event(Event::Confirm(number));
    }

    pub(super) fn follow_layer_settings(
        &mut self,
        now: Instant,
        settings: LayerSettings,
        outcome: Result<(), NotSaved>,
    ) {
        let LayerSettings { node_id, bit_rate } = settings;
        if outcome.is_ok() {
            self.set_value(now, self.objects.slots.node_id, node_id.get().into());
            if let Some(bit_rate) = bit_rate {
                let number = BIT_RATE_MAX.saturating_sub(bit_rate.index());
                self.set_value(now, self.objects.slots.bit_rate, number.into());
            }
        }
        self.node.handle_lss_stored(outcome.map_err(|NotSaved| StoreError::AccessFailed));
    }

    /// The user touched the device: it takes the node-ID of this offer, unless there is a newer one
    /// already.
    pub(super) fn take_offer(&mut self, offer: u8) {
        if self.offer == Some(offer) {
            self.node.take_offered_node_id();
            self.tell_offer(0, self.node.pending_node_id().map_or(0, NodeId::get));
        }
    }

    /// Nothing is to be shown any more.
    pub(super) fn end_offer(&mut self) {
        if self.offer.take().is_some() {
            self.tell_offer(0, 0);
        }
    }

    fn tell_offer(&mut self, number: u8, node_id: u8) {
        let value = u32::from_le_bytes([node_id, number, 0, 0]);
        if self.objects.link.write(OFFER, value, Kind::Value).is_err() {
            self.send(Emergency::OFFER_NOT_SENT);
        }
    }

    pub(super) fn switch_bit_rate(&mut self, now: Instant) {
        let Some((step, left)) = self.bit_timing.and_then(|timing| timing.step(now)) else {
            return;
        };
        self.bit_timing = left;
        match step {
            Step::Switch(bit_rate, node_id) => {
                self.bit_rate = BIT_RATE_MAX.saturating_sub(bit_rate.index());
                self.rebuild_node(node_id);
                self.event(Event::FiltersChanged);
            }
            Step::Boot => {
                self.boot_up_by = Some(now);
                self.boot_up(now);
            }
        }
    }
}
