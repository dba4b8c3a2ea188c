//! Events of a slave's controllers other than received frames.

use super::SlaveCore;
use crate::emcy::ErrorCode;
use crate::link::port::Health;
use crate::node::buses::BusNews;
use crate::node::events::SlaveEvents;
use crate::node::services::Extension;
use crate::node::turn::Turn;
use crate::node::{Device, FailCause, LinkEvent};
use crate::types::{Bus, CobId, Duration, Frame, Instant};

/// From an overrun to the next frames of all states. A receiver that is too slow has many overruns: they are sent once for all.
const AFTER_OVERRUN: Duration = Duration::from_millis(1_000);

impl<D: Device, E: Extension<D>> SlaveCore<D, E> {
    /// Counts the event, follows the error state, and passes the ends of transmissions to the SDO servers.
    /// `is_active`: the node uses this bus.
    pub fn on_bus_event(
        &mut self,
        bus: Bus,
        is_active: bool,
        event: &LinkEvent,
        turn: &mut Turn<'_, E::SlaveEvent>,
    ) {
        match self.services.on_link(bus, event, turn.now) {
            Some(BusNews::Health(health)) => self.on_health(bus, health, turn),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, turn);
                turn.out.event(E::SlaveEvent::bus_failed(bus));
            }
            Some(BusNews::Stalled) => turn.out.event(E::SlaveEvent::bus_stalled(bus)),
            None => {}
        }
        if let LinkEvent::Transmitted { frame, .. } = event
            && self.control.no_sooner().on_sent(frame)
        {
            self.services.emcy_mut();
        }
        match event {
            LinkEvent::Transmitted { frame, .. } => {
                self.on_sent(frame, turn.now);
                if is_active {
                    self.services.on_frame_end(frame, true, turn.now);
                }
            }
            LinkEvent::Failed { frame, cause } => {
                self.on_sent(frame, turn.now);
                // What is over the budget is reported as such.
                if *cause != FailCause::OverBudget && self.services.tpdos().is_event(frame.id()) {
                    turn.out.event(E::SlaveEvent::not_sent(bus, frame.id(), frame.padded()));
                } else if is_active {
                    self.services.on_frame_end(frame, false, turn.now);
                }
            }
            LinkEvent::Overrun { .. } => {
                if is_active {
                    // It may have been the boot-up message of the master.
                    self.services.send_states(turn.now + AFTER_OVERRUN);
                }
                self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
            }
            LinkEvent::Unsent { frames } => {
                // Some may have been segments that an SDO server waits for.
                self.services.on_sdo_unsent(*frames);
                self.services.occurred(ErrorCode::CAN_OVERRUN, bus);
            }
            LinkEvent::Counters(_) => self.services.refresh_health(),
            _ => {}
        }
    }

    fn on_sent(&mut self, frame: &Frame, now: Instant) {
        if frame.id() == CobId::sdo_response(self.control.id()) {
            self.services.on_sdo_sent();
        } else if self.services.is_second_sdo_answer(frame.id()) {
            self.services.on_second_sdo_sent();
        } else if E::IS_GUARDED && frame.id() == CobId::heartbeat(self.control.id()) {
            self.check_cob_ids(now);
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, turn: &mut Turn<'_, E::SlaveEvent>) {
        self.services.on_health(bus, &health);
        self.services.refresh_health();
        turn.out.event(E::SlaveEvent::health(bus, health));
    }
}
