//! Buses of a node: counters, health, recovery from bus-off, joining and leaving.

use crate::heartbeat::is_toggled;
use crate::link::depth::Depth;
use crate::link::port::{ErrorState, Health};
use crate::node::{BusCommand, FailCause, LinkEvent, Outbox};
use crate::redundancy::{BusAccess, BusOffPolicy, BusOffRecovery, Parameters, RecoveryStep};
use crate::types::{Bus, Duration, Frame, Instant, NmtState, PerBus, Scet, earliest};

/// Counters of the frames of one bus. `received` and `sent` wrap; all others stay at their maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Frames received, whatever the node did with them.
    pub received: u32,
    /// Frames sent and acknowledged.
    pub sent: u32,
    /// Received frames with an error in the protocol: wrong length, unknown command or state. Heartbeats with bit 7 set,
    /// whose state is used all the same.
    pub malformed: u16,
    /// Received frames without an error that were not for this node in this state on this bus.
    pub ignored: u16,
    /// Least number of frames lost in the receiver. An overrun of its FIFO counts as one, however many frames it
    /// lost.
    pub lost: u16,
    /// Frames not sent: refused by this node, in the wrong state, on the inactive bus, or above its budget.
    pub refused: u16,
    /// Frames not sent: the bus was left.
    pub bus_left: u16,
    /// Frames not sent: the lifetime ended.
    pub expired: u16,
    /// Frames not sent: a queue of the node or of the bus was full.
    pub queue_full: u16,
    /// Frames not sent: the controller aborted them.
    pub aborted: u16,
}

impl Counters {
    /// Returns the number of frames that were not sent, for any cause.
    pub const fn failed(&self) -> u16 {
        self.refused
            .saturating_add(self.bus_left)
            .saturating_add(self.expired)
            .saturating_add(self.queue_full)
            .saturating_add(self.aborted)
    }
}

/// State of a node at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Time since power-on.
    pub uptime: Duration,
    /// Local spacecraft time (object 2011h).
    pub scet: Scet,
    /// NMT state of the node.
    pub state: NmtState,
    /// Bus that the node considers active.
    pub active: Bus,
    /// Redundancy parameters (objects 1016h, 1017h, 2000h), with the present Bdefault and Ctoggle.
    pub redundancy: Parameters,
    /// Counters of the frames of each bus.
    pub counters: PerBus<Counters>,
    /// Error state and counters of each bus (objects 2020h, 2021h).
    pub health: PerBus<Health>,
}

/// Both buses of a node.
#[derive(Clone, Debug)]
pub(super) struct Buses {
    access: BusAccess,
    pub counters: PerBus<Counters>,
    pub health: PerBus<Health>,
    recovery: PerBus<BusOffRecovery>,
    /// The error state that was reported last.
    reported: PerBus<ErrorState>,
    /// The node commanded it to go on this bus, and not to leave it since.
    joined: PerBus<bool>,
}

/// Change of a bus that a node has to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BusNews {
    /// The error state changed.
    Health(Health),
    /// The controller went bus-off too often.
    Failed(Health),
    /// The controller does not get on or off the bus.
    Stalled,
}

impl Buses {
    pub fn new(access: BusAccess, policy: BusOffPolicy) -> Self {
        Buses {
            access,
            counters: PerBus::default(),
            health: PerBus::default(),
            recovery: PerBus::from_fn(|_| BusOffRecovery::new(policy)),
            reported: PerBus::default(),
            joined: PerBus::default(),
        }
    }

    /// Returns how the node reaches its buses.
    pub const fn access(&self) -> BusAccess {
        self.access
    }

    /// Keeps the node on one bus from power-on on. It never chooses the other one.
    pub const fn keep_to_one(&mut self) {
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
    pub fn join_one<E>(&mut self, bus: Bus, out: &mut Outbox<E>) {
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

    /// Counts an event and follows the error state. Returns a change that the node has to report.
    pub fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant) -> Option<BusNews> {
        let counters = &mut self.counters[bus];
        match event {
            LinkEvent::Received { .. } => self.received(bus),
            LinkEvent::Transmitted { .. } => counters.sent = counters.sent.wrapping_add(1),
            LinkEvent::Failed { cause, .. } => count(match cause {
                FailCause::BusLeft => &mut counters.bus_left,
                FailCause::Expired => &mut counters.expired,
                FailCause::QueueFull => &mut counters.queue_full,
                FailCause::Aborted => &mut counters.aborted,
                FailCause::OverBudget => &mut counters.refused,
            }),
            LinkEvent::Unsent { frames } => {
                counters.queue_full = counters.queue_full.saturating_add(*frames);
            }
            LinkEvent::Overrun { lost } => counters.lost = counters.lost.saturating_add(*lost),
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
        }
        None
    }

    /// Takes the error state of a controller. Returns whether the controller was bus-off and has recovered.
    pub fn note_state(&mut self, bus: Bus, state: ErrorState) -> bool {
        let was_off = core::mem::replace(&mut self.reported[bus], state) == ErrorState::BusOff;
        was_off && state != ErrorState::BusOff
    }

    /// Counts a received frame.
    pub fn received(&mut self, bus: Bus) {
        let counters = &mut self.counters[bus];
        counters.received = counters.received.wrapping_add(1);
    }

    /// Counts a received frame with an error in the protocol.
    pub fn malformed(&mut self, bus: Bus) {
        count(&mut self.counters[bus].malformed);
    }

    /// Counts a heartbeat that was taken as malformed if its bit 7 is set.
    pub fn taken(&mut self, bus: Bus, heartbeat: &Frame) {
        if is_toggled(heartbeat) {
            self.malformed(bus);
        }
    }

    /// Counts a received frame that is not for this node in this state.
    pub fn ignored(&mut self, bus: Bus) {
        count(&mut self.counters[bus].ignored);
    }

    /// Counts a frame that this node refuses to send.
    pub fn refused(&mut self, bus: Bus) {
        count(&mut self.counters[bus].refused);
    }

    pub fn is_failed(&self, bus: Bus) -> bool {
        self.recovery[bus].is_failed()
    }

    /// Begins the recoveries that are due. Returns a bus that did not recover in time and is failed now. Call it
    /// until `None`.
    pub fn poll<E, D: Depth>(&mut self, now: Instant, out: &mut Outbox<E, D>) -> Option<Bus> {
        for &bus in &Bus::ALL {
            match self.recovery[bus].poll(now) {
                Some(RecoveryStep::Recover) => out.command(bus, BusCommand::Recover),
                Some(RecoveryStep::Failed) => return Some(bus),
                None => {}
            }
        }
        None
    }

    pub fn deadline(&self) -> Option<Instant> {
        earliest(&[self.recovery.nominal.deadline(), self.recovery.redundant.deadline()])
    }
}

#[cfg_attr(target_os = "none", inline(never))] // of many callers: on a chip of 32 bits a call is shorter
fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}
