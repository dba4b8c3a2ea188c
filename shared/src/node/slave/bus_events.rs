//! What the controllers of a slave tell beside received frames.

use super::{Out, Slave};
use crate::emcy::ErrorCode;
use crate::link::port::{ErrorState, Health};
use crate::link::{Bus, CobId, Frame};
use crate::node::SlaveEvent;
use crate::node::buses::BusNews;
use crate::od::Objects;
use crate::od::communication::Mapping;
use crate::od::spacecraft::BusHealth;
use crate::runner::LinkEvent;
use crate::time::Instant;

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> Slave<A, R, T, M> {
    pub(super) fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        match self.buses.on_link(bus, event, now) {
            Some(BusNews::Health(health)) => self.on_health(bus, health, now, out),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, now, out);
                out.event(SlaveEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => out.event(SlaveEvent::BusStalled { bus }),
            None => {}
        }
        match event {
            LinkEvent::Transmitted { frame, .. } | LinkEvent::Failed { frame, .. } => {
                self.on_sent(frame, now);
            }
            LinkEvent::Overrun { .. } => self.occurred(ErrorCode::CAN_OVERRUN, bus, now),
            LinkEvent::Unsent { frames } => {
                // Some may have been segments that the SDO server waits for.
                (0..*frames).for_each(|_| self.device.on_sdo_sent());
                self.occurred(ErrorCode::CAN_OVERRUN, bus, now);
            }
            LinkEvent::Counters(_) => self.refresh_health(),
            _ => {}
        }
        // Recoveries begin and end here.
        self.wake(self.buses.deadline());
    }

    fn on_sent(&mut self, frame: &Frame, now: Instant) {
        if frame.id() == CobId::sdo_response(self.id) {
            self.device.on_sdo_sent();
            self.next = now;
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, now: Instant, out: &mut Out) {
        let source = bus.bdefault();
        let before = self.told_state(bus);
        match health.state {
            ErrorState::Active => self.device.clear(ErrorCode::CAN_PASSIVE, source),
            ErrorState::Passive => self.device.raise(ErrorCode::CAN_PASSIVE, [source, 0, 0, 0, 0]),
            ErrorState::BusOff => {}
        }
        if before == ErrorState::BusOff as u8 && health.state != ErrorState::BusOff {
            self.occurred(ErrorCode::BUS_OFF_RECOVERED, bus, now);
        }
        self.refresh_health();
        self.next = now;
        out.event(SlaveEvent::Health { bus, health });
    }

    /// The error state that the dictionary tells.
    fn told_state(&self, bus: Bus) -> u8 {
        let objects = &self.device.dictionary.objects.spacecraft;
        match bus {
            Bus::Nominal => objects.health_nominal.state,
            Bus::Redundant => objects.health_redundant.state,
        }
    }

    /// An error that is over when it is told.
    fn occurred(&mut self, code: ErrorCode, bus: Bus, now: Instant) {
        let source = bus.bdefault();
        self.device.raise(code, [source, 0, 0, 0, 0]);
        self.device.clear(code, source);
        self.next = now;
    }

    /// The objects of the moment: 2011h, 2020h and 2021h.
    #[inline(never)] // few requests ask for them
    pub(super) fn refresh(&mut self, now: Instant) {
        self.device.dictionary.objects.spacecraft.scet_get = self.clock.at(now).into();
        self.refresh_health();
    }

    fn refresh_health(&mut self) {
        let of = |bus| BusHealth::new(&self.buses.health[bus], &self.buses.counters[bus]);
        let (nominal, redundant) = (of(Bus::Nominal), of(Bus::Redundant));
        let objects = &mut self.device.dictionary.objects.spacecraft;
        (objects.health_nominal, objects.health_redundant) = (nominal, redundant);
    }
}
