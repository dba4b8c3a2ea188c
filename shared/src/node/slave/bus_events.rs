//! What the controllers of a slave tell beside received frames.

use super::{Out, Slave};
use crate::emcy::ErrorCode;
use crate::link::port::Health;
use crate::node::buses::BusNews;
use crate::node::{Device, LinkEvent, SlaveEvent};
use crate::types::{Bus, CobId, Frame, Instant};

impl<D: Device> Slave<D> {
    pub(super) fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        match self.services.buses.on_link(bus, event, now) {
            Some(BusNews::Health(health)) => self.on_health(bus, health, now, out),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, now, out);
                out.event(SlaveEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => out.event(SlaveEvent::BusStalled { bus }),
            None => {}
        }
        match event {
            LinkEvent::Transmitted { frame, stamp } if frame.id() == CobId::heartbeat(self.id) => {
                self.identity.on_sent(stamp.at);
            }
            LinkEvent::Transmitted { frame, .. } | LinkEvent::Failed { frame, .. } => {
                self.on_sent(frame, now);
            }
            LinkEvent::Overrun { .. } => self.lost(bus, now),
            LinkEvent::Unsent { frames } => {
                // Some may have been segments that the SDO server waits for.
                (0..*frames).for_each(|_| self.services.on_sdo_sent());
                self.lost(bus, now);
            }
            LinkEvent::Counters(_) => self.services.refresh_health(),
            _ => {}
        }
        // Recoveries begin and end here.
        self.services.wake(self.services.buses.deadline());
        self.run(now, now, out);
    }

    fn lost(&mut self, bus: Bus, now: Instant) {
        self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
        self.services.next = now;
    }

    fn on_sent(&mut self, frame: &Frame, now: Instant) {
        if frame.id() == CobId::sdo_response(self.id) {
            self.services.on_sdo_sent();
            self.services.next = now;
        }
        if self.warning.is_some() && frame.data().starts_with(&ErrorCode::HEARTBEAT.get().to_le_bytes()) {
            self.warning = None;
            self.services.next = now;
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, now: Instant, out: &mut Out) {
        self.services.on_health(bus, &health);
        self.services.refresh_health();
        self.services.next = now;
        out.event(SlaveEvent::Health { bus, health });
    }
}
