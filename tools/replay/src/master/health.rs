//! States of the controllers of a master, and recovery from bus-off, which runs along.

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::redundancy::{BusOffPolicy, BusOffRecovery, RecoveryStep};
use ecss_can::types::{Bus, Instant, PerBus, earliest};

use super::Master;

/// States of both controllers.
pub struct Controllers {
    health: PerBus<Health>,
    recovery: PerBus<BusOffRecovery>,
}

impl Controllers {
    /// Makes the states of controllers without an error.
    pub fn new(policy: BusOffPolicy) -> Controllers {
        Controllers { health: PerBus::default(), recovery: PerBus::from_fn(|_| BusOffRecovery::new(policy)) }
    }

    /// The node only listens: there is nothing to recover.
    pub fn leave(&mut self) {
        Bus::ALL.into_iter().for_each(|bus| self.recovery[bus].leave());
    }

    /// Returns when a step of a recovery is due.
    pub fn deadline(&self) -> Option<Instant> {
        earliest(&[self.recovery.nominal.deadline(), self.recovery.redundant.deadline()])
    }
}

impl Master {
    /// The program read ESR: another value, or after an interrupt.
    pub(super) fn on_health(&mut self, bus: Bus, health: Health, now: Instant) {
        if health.state == ErrorState::BusOff && self.controllers.health[bus].state == ErrorState::BusOff {
            // Another bus-off. The program did not look in between.
            self.take_health(bus, Health::default(), now);
        }
        self.take_health(bus, health, now);
    }

    fn take_health(&mut self, bus: Bus, health: Health, now: Instant) {
        let known = std::mem::replace(&mut self.controllers.health[bus], health);
        if self.redundancy.is_active() && verdict(&known) != verdict(&health) {
            self.controllers.recovery[bus].on_state(health.state, now);
            self.report_health(bus, now);
        }
    }

    /// Reports the states that the program found as a standby. It looks at its controllers again when it joins their buses.
    pub(super) fn join(&mut self, now: Instant) {
        for bus in Bus::ALL {
            let health = std::mem::take(&mut self.controllers.health[bus]);
            self.on_health(bus, health, now);
        }
    }

    pub(super) fn report_health(&mut self, bus: Bus, now: Instant) {
        let Controllers { health, recovery } = &self.controllers;
        self.redundancy.on_health(bus, health[bus], recovery[bus].is_failed(), now);
    }

    /// Does what is due of the recoveries.
    pub(super) fn poll_recoveries(&mut self, now: Instant) {
        for bus in Bus::ALL {
            if self.controllers.recovery[bus].poll(now) == Some(RecoveryStep::Failed) {
                self.report_health(bus, now);
            }
        }
    }
}

/// Returns what a node acts on. It hears of other changes later, as counters.
fn verdict(health: &Health) -> (ErrorState, bool) {
    (health.state, health.state == ErrorState::Passive && health.last_error == LastError::Ack)
}
