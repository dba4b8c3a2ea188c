//! Events of a slave's controllers other than received frames.

use super::{Canopen, Out};
use crate::emcy::ErrorCode;
use crate::link::port::Health;
use crate::node::buses::BusNews;
use crate::node::{Device, Extension, FailCause, LinkEvent, SlaveEvent};
use crate::types::{Bus, CobId, Duration, Frame, Instant};

/// From an overrun to the next frames of all states. A receiver that is too slow has many overruns: they are sent once for all.
const AFTER_OVERRUN: Duration = Duration::from_millis(1_000);

impl<D: Device, E: Extension> Canopen<D, E> {
    /// Counts the event, follows the error state, and passes the ends of transmissions to the SDO server.
    /// `is_active`: the node uses this bus.
    pub fn on_bus_event(
        &mut self,
        bus: Bus,
        is_active: bool,
        event: &LinkEvent,
        now: Instant,
        out: &mut Out,
    ) {
        match self.services.buses.on_link(bus, event, now) {
            Some(BusNews::Health(health)) => self.on_health(bus, health, now, out),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, now, out);
                out.event(SlaveEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => out.event(SlaveEvent::BusStalled { bus }),
            None => {}
        }
        if let LinkEvent::Transmitted { frame, .. } = event
            && self.control.on_sent(frame)
        {
            self.services.next = now;
        }
        match event {
            LinkEvent::Transmitted { frame, .. } => {
                self.on_sent(frame, now);
                if is_active {
                    self.services.on_frame_end(frame, true, now);
                }
            }
            LinkEvent::Failed { frame, cause } => {
                self.on_sent(frame, now);
                // What is over the budget is reported as such.
                if *cause != FailCause::OverBudget && self.services.is_lost_event(frame) {
                    out.event(SlaveEvent::NotSent { bus, id: frame.id(), data: frame.padded() });
                } else if is_active {
                    self.services.on_frame_end(frame, false, now);
                }
            }
            LinkEvent::Overrun { .. } => {
                if is_active {
                    // It may have been the boot-up message of the master.
                    self.services.dictionary.tpdos.send_states(now + AFTER_OVERRUN);
                }
                self.lost(bus, now);
            }
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
    }

    fn lost(&mut self, bus: Bus, now: Instant) {
        self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
        self.services.next = now;
    }

    fn on_sent(&mut self, frame: &Frame, now: Instant) {
        if frame.id() == CobId::sdo_response(self.control.id()) {
            self.services.on_sdo_sent();
            self.services.next = now;
        } else if E::IS_GUARDED && frame.id() == CobId::heartbeat(self.control.id()) {
            self.check_cob_ids(now);
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, now: Instant, out: &mut Out) {
        self.services.on_health(bus, &health);
        self.services.refresh_health();
        self.services.next = now;
        out.event(SlaveEvent::Health { bus, health });
    }
}
