//! What every node does with its two buses: counting, health, recovery, joining and leaving.

use crate::link::depth::Depth;
use crate::link::port::{ErrorState, Health};
use crate::node::{BusCommand, FailCause, LinkEvent, Outbox};
use crate::redundancy::{BusAccess, BusOffPolicy, BusOffRecovery, Parameters, RecoveryStep};
use crate::types::{Bus, Duration, Instant, NmtState, PerBus, Scet, earliest};

/// Frames of one bus. The first two wrap, all others stay at their maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Received, whatever became of them.
    pub received: u32,
    /// Sent and acknowledged.
    pub sent: u32,
    /// Received, but not as the protocol has them: wrong length, unknown command or state.
    pub malformed: u16,
    /// Received well-formed, but not for this node in this state on this bus.
    pub ignored: u16,
    /// Lost in the receiver, at least: an overrun of its FIFO counts as one, however many frames it cost.
    pub lost: u16,
    /// Not sent: refused by this node, in the wrong state, on the inactive bus, or above its budget.
    pub refused: u16,
    /// Not sent: the bus was left.
    pub bus_left: u16,
    /// Not sent: the lifetime ended.
    pub expired: u16,
    /// Not sent: a queue was full, of the node or of the bus.
    pub queue_full: u16,
    /// Not sent: the controller gave up.
    pub aborted: u16,
}

impl Counters {
    /// Not sent, for whatever cause.
    pub const fn failed(&self) -> u16 {
        self.refused
            .saturating_add(self.bus_left)
            .saturating_add(self.expired)
            .saturating_add(self.queue_full)
            .saturating_add(self.aborted)
    }
}

/// A node as it is now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Since power-on.
    pub uptime: Duration,
    /// Local spacecraft time (object 2011h).
    pub scet: Scet,
    /// NMT state.
    pub state: NmtState,
    /// The bus considered active.
    pub active: Bus,
    /// Redundancy parameters, Bdefault and Ctoggle as they are now (objects 1016h, 1017h, 2000h).
    pub redundancy: Parameters,
    /// Frames of each bus.
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

/// What a node has to report of a bus.
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

    /// How the node reaches its buses.
    pub const fn access(&self) -> BusAccess {
        self.access
    }

    /// From power-on the node takes part in one bus, and chooses no other.
    pub const fn keep_to_one(&mut self) {
        self.access = BusAccess::Selective;
    }

    /// Go on the bus or buses, at power-on, or from being silent there.
    pub fn join<E, D: Depth>(&mut self, active: Bus, out: &mut Outbox<E, D>) {
        for bus in Bus::ALL {
            self.joined[bus] = self.is_joined(bus, active);
            if self.joined[bus] {
                out.command(bus, BusCommand::Join);
            }
        }
    }

    /// Go on both buses, silent: abort what is pending, receive, and drive no dominant bit.
    pub fn listen<E>(&mut self, out: &mut Outbox<E>) {
        for bus in Bus::ALL {
            self.joined[bus] = false;
            self.recovery[bus].leave();
            out.command(bus, BusCommand::Listen);
        }
    }

    /// Go on the only bus, at power-on.
    pub fn join_one<E>(&mut self, bus: Bus, out: &mut Outbox<E>) {
        self.joined[bus] = true;
        out.command(bus, BusCommand::Join);
    }

    /// The active bus changed: nothing that was meant for the old one may go out there later.
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

    /// Whether the node takes part in `bus`: what a left one still reports is of the past.
    pub fn is_joined(&self, bus: Bus, active: Bus) -> bool {
        self.access == BusAccess::Parallel || bus == active
    }

    /// Counts an event and follows the error state.
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

    /// Takes the error state of a controller. Returns whether it was bus-off and is no more.
    pub fn has_recovered(&mut self, bus: Bus, state: ErrorState) -> bool {
        let was_off = core::mem::replace(&mut self.reported[bus], state) == ErrorState::BusOff;
        was_off && state != ErrorState::BusOff
    }

    /// A received frame.
    pub fn received(&mut self, bus: Bus) {
        let counters = &mut self.counters[bus];
        counters.received = counters.received.wrapping_add(1);
    }

    /// A received frame that is not as the protocol has it.
    pub fn malformed(&mut self, bus: Bus) {
        count(&mut self.counters[bus].malformed);
    }

    /// A received frame that is not for this node in this state.
    pub fn ignored(&mut self, bus: Bus) {
        count(&mut self.counters[bus].ignored);
    }

    /// Something that this node will not send.
    pub fn refused(&mut self, bus: Bus) {
        count(&mut self.counters[bus].refused);
    }

    /// A frame held back until its lifetime ended.
    pub fn expired(&mut self, bus: Bus) {
        count(&mut self.counters[bus].expired);
    }

    /// A frame held back until its bus was left.
    pub fn left(&mut self, bus: Bus) {
        count(&mut self.counters[bus].bus_left);
    }

    pub fn is_failed(&self, bus: Bus) -> bool {
        self.recovery[bus].is_failed()
    }

    /// Begins the recoveries that are due. A bus that did not come back in time and is failed now; call until `None`.
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
