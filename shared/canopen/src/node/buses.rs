//! Buses of a node: health, recovery from bus-off, joining and leaving, and counters of the frames.

use crate::heartbeat::is_toggled;
use crate::link::access::BusAccess;
use crate::link::bus_off::{BusOffPolicy, BusOffRecovery, RecoveryStep};
use crate::link::depth::Depth;
use crate::link::port::{ErrorState, Health};
use crate::node::counters::count;
use crate::node::{BusCommand, Counters, FailCause, LinkEvent, Outbox, Turn};
use crate::types::{Bus, Frame, Instant, PerBus};

/// Both buses of a node.
#[derive(Clone, Debug)]
pub struct Buses {
    access: BusAccess,
    /// Error state and counters of each bus.
    health: PerBus<Health>,
    counters: PerBus<Counters>,
    recovery: PerBus<BusOffRecovery>,
    /// The error state that was reported last.
    reported: PerBus<ErrorState>,
    /// The node commanded it to go on this bus, and not to leave it since.
    joined: PerBus<bool>,
}

/// Change of a bus that a node has to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusNews {
    /// The error state changed.
    Health(Health),
    /// The controller went bus-off too often.
    Failed(Health),
    /// The controller does not get on or off the bus.
    Stalled,
}

impl Buses {
    /// Makes both buses before power-on.
    pub fn new(access: BusAccess, policy: BusOffPolicy) -> Self {
        Buses {
            access,
            health: PerBus::default(),
            counters: PerBus::default(),
            recovery: PerBus::from_fn(|_| BusOffRecovery::new(policy)),
            reported: PerBus::default(),
            joined: PerBus::default(),
        }
    }

    /// Returns how the node reaches its buses.
    pub const fn access(&self) -> BusAccess {
        self.access
    }

    /// Returns error state and counters of each bus.
    pub const fn health(&self) -> &PerBus<Health> {
        &self.health
    }

    /// Returns the counters of the frames of each bus.
    pub const fn counters(&self) -> &PerBus<Counters> {
        &self.counters
    }

    /// Resets the counters of both buses to zero.
    pub fn reset_counters(&mut self) {
        self.counters = PerBus::default();
    }

    /// Returns the number of frames received on each bus; wraps.
    pub fn received(&self) -> PerBus<u32> {
        PerBus::from_fn(|bus| self.counters[bus].received)
    }

    /// Counts a received frame.
    pub fn count_received(&mut self, bus: Bus) {
        let counters = &mut self.counters[bus];
        counters.received = counters.received.wrapping_add(1);
    }

    /// Counts a received frame with an error in the protocol.
    pub fn count_malformed(&mut self, bus: Bus) {
        count(&mut self.counters[bus].malformed);
    }

    /// Counts a heartbeat that was taken as malformed if its bit 7 is set.
    pub fn count_heartbeat(&mut self, bus: Bus, heartbeat: &Frame) {
        if is_toggled(heartbeat) {
            self.count_malformed(bus);
        }
    }

    /// Counts a received frame that is not for this node in this state.
    pub fn count_ignored(&mut self, bus: Bus) {
        count(&mut self.counters[bus].ignored);
    }

    /// Counts a frame that this node refuses to send.
    pub fn count_refused(&mut self, bus: Bus) {
        count(&mut self.counters[bus].refused);
    }

    /// Counts a frame that was not sent.
    pub fn count_failed(&mut self, bus: Bus, cause: FailCause) {
        self.counters[bus].on_failed(cause);
    }

    /// Keeps the node on one bus from power-on on. It never chooses the other one.
    pub(crate) const fn keep_to_one(&mut self) {
        self.access = BusAccess::Selective;
    }

    /// Joins the bus or buses, at power-on or after the node was silent there.
    pub fn join<E, D: Depth>(&mut self, active: Bus, out: &mut Outbox<E, D>) {
        for bus in Bus::ALL {
            self.joined[bus] = self.is_joined(bus, active);
            if self.joined[bus] {
                out.command(bus, BusCommand::Join);
            }
        }
    }

    /// Listens on both buses: aborts what is pending, receives, and drives no dominant bit.
    pub fn listen<E>(&mut self, out: &mut Outbox<E>) {
        for bus in Bus::ALL {
            self.joined[bus] = false;
            self.recovery[bus].leave();
            out.command(bus, BusCommand::Listen);
        }
    }

    /// Joins the only bus, at power-on.
    pub(crate) fn join_one<E>(&mut self, bus: Bus, out: &mut Outbox<E>) {
        self.joined[bus] = true;
        out.command(bus, BusCommand::Join);
    }

    /// Changes the active bus. Nothing that waits for the old bus may be sent there later.
    pub fn change<E, D: Depth>(&mut self, from: Bus, to: Bus, out: &mut Outbox<E, D>) {
        match self.access {
            BusAccess::Parallel => out.command(from, BusCommand::Abandon),
            BusAccess::Selective => {
                (self.joined[from], self.joined[to]) = (false, true);
                self.recovery[from].leave();
                // What the bus was like when it was left says nothing about it now.
                (self.health[to], self.reported[to]) = (Health::default(), ErrorState::Active);
                out.command(from, BusCommand::Leave);
                out.command(to, BusCommand::Join);
            }
        }
    }

    /// Returns whether the node takes part in `bus`. A bus that was left only reports what happened before.
    pub fn is_joined(&self, bus: Bus, active: Bus) -> bool {
        self.access.joins(bus, active)
    }

    /// Counts an event and follows the state of the controller. Returns a change that the node has to report.
    pub fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant) -> Option<BusNews> {
        match event {
            LinkEvent::Counters(health) => self.health[bus] = *health,
            LinkEvent::Stalled => return Some(BusNews::Stalled),
            LinkEvent::Health(health) => {
                self.health[bus] = *health;
                if !self.joined[bus] {
                    // The last frame on a bus that is being left: nothing to recover there.
                    return Some(BusNews::Health(*health));
                }
                return Some(match self.recovery[bus].on_state(health.state, now) {
                    Some(RecoveryStep::Failed) => BusNews::Failed(*health),
                    _ => BusNews::Health(*health),
                });
            }
            event => self.counters[bus].on_link(event),
        }
        None
    }

    /// Takes the error state of a controller. Returns whether the controller was bus-off and has recovered.
    pub(crate) fn note_state(&mut self, bus: Bus, state: ErrorState) -> bool {
        let was_off = core::mem::replace(&mut self.reported[bus], state) == ErrorState::BusOff;
        was_off && state != ErrorState::BusOff
    }

    /// Returns whether the controller went bus-off too often.
    pub fn is_failed(&self, bus: Bus) -> bool {
        self.recovery[bus].is_failed()
    }

    /// Begins the recoveries that are due. Returns a bus that did not recover in time and is failed now. Call it
    /// until `None`.
    pub fn poll<E, D: Depth>(&mut self, turn: &mut Turn<'_, E, D>) -> Option<Bus> {
        for &bus in &Bus::ALL {
            match self.recovery[bus].poll(turn.until) {
                Some(RecoveryStep::Recover) => turn.out.command(bus, BusCommand::Recover),
                Some(RecoveryStep::Failed) => return Some(bus),
                None => {}
            }
        }
        None
    }

    /// Returns when a recovery is due.
    pub fn deadline(&self) -> Option<Instant> {
        let PerBus { nominal, redundant } = &self.recovery;
        let due = nominal.due().min(redundant.due());
        (due < Instant::NEVER).then_some(due)
    }
}
