//! What a node and its surroundings agree on: events and time in, commands and application events out.
//!
//! Sans-IO: the async shell is [`crate::runner`], tests call a node directly.

use heapless::deque::DequeInner;

use crate::link::Stamp;
use crate::link::depth::{Depth, Places};
use crate::link::port::{Filter, Health};
use crate::link::queue::Outgoing;
use crate::types::{Bus, Duration, Frame, Instant, PerBus};

/// Commands in an outbox, frames in the priority queue of a bus, and events that may wait for the application: of a node with
/// the whole protocol.
pub const QUEUE_DEPTH: usize = 32;
/// [`Depth`] of a node with the whole protocol.
pub type Usual = Places<QUEUE_DEPTH>;
/// Most acceptance filters that a node asks a port for: it notes those that have changed in the bits of a word.
pub const MAX_FILTERS: usize = u32::BITS as usize;

/// Acceptance filters of a node. A full list may lack some: then its port admits every frame.
pub type Filters = heapless::Vec<Filter, MAX_FILTERS>;

/// Report of a bus to its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum LinkEvent {
    /// A frame that passed the filters.
    Received {
        /// The frame.
        frame: Frame,
        /// End of the frame.
        stamp: Stamp,
    },
    /// A frame of ours was acknowledged by a peer.
    Transmitted {
        /// The frame.
        frame: Frame,
        /// End of the frame.
        stamp: Stamp,
    },
    /// A frame of ours did not go out.
    Failed {
        /// The frame.
        frame: Frame,
        /// Why.
        cause: FailCause,
    },
    /// Frames of ours were dropped before they came to the bus: the outbox was full.
    Unsent {
        /// How many since the last report.
        frames: u16,
    },
    /// Received frames were lost before the node could see them.
    Overrun {
        /// How many since the last report, at least.
        lost: u16,
    },
    /// The error state of the controller changed.
    Health(Health),
    /// Its error counters moved since the last report. Reported before the next event of the controller.
    Counters(Health),
    /// The controller does not get on or off the bus: it is defective, or the bus is dominant all the time.
    Stalled,
}

/// Why a frame did not go out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailCause {
    /// The node left the bus while the frame was pending.
    BusLeft,
    /// Its lifetime ended.
    Expired,
    /// The transmit queue was full, or a frame that the network lives on took its place there.
    QueueFull,
    /// The controller gave the frame up by itself (bus-off, reset).
    Aborted,
    /// The node sends too much: its [budget](crate::link::budget) is spent.
    OverBudget,
}

/// Command of a node to a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum BusCommand {
    /// Send a frame.
    Send(Outgoing),
    /// Abort everything pending, queue and mailboxes; stay on the bus (parallel access).
    Abandon,
    /// Take part in the bus.
    Join,
    /// Abort everything pending and listen: receive, and drive no dominant bit, not even an acknowledgement.
    Listen,
    /// Abort everything pending and go off the bus, silent (selective access).
    Leave,
    /// Begin recovery from bus-off.
    Recover,
    /// Admit other frames by one of the filters set at the start.
    Filter {
        /// Number of the filter.
        number: u8,
        /// What it admits from now on.
        filter: Filter,
    },
}

/// A protocol node: master or slave, sans-IO.
pub trait Node: 'static {
    /// Events for its application.
    type Event;
    /// Requests of its application.
    type Request;
    /// Depth of its queues: [`Usual`], or less for a small node.
    type Depth: Depth;

    /// What it receives, by its dictionary. Each bus has these filters before power-on; the last ones become one that admits
    /// every frame where a port has [too few](crate::link::port::CanPort::FILTERS).
    fn filters(&self) -> Filters;

    /// One of [`Node::filters`] as it is now. Each bus sets one of its filters anew at each look at its controller, as a bit may have
    /// flipped there (ECSS 6.10d). `None` beyond the last one, and always from a node that does not guard them.
    fn filter(&self, _number: usize) -> Option<Filter> {
        None
    }

    /// Power-on, at `now`. Called once, before anything else.
    fn start(&mut self, now: Instant, out: &mut Outbox<Self::Event, Self::Depth>);

    /// Something happened on a bus.
    fn on_link(
        &mut self,
        bus: Bus,
        event: &LinkEvent,
        now: Instant,
        out: &mut Outbox<Self::Event, Self::Depth>,
    );

    /// A frame was received: as [`LinkEvent::Received`], without the copies.
    fn on_received(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        now: Instant,
        out: &mut Outbox<Self::Event, Self::Depth>,
    ) {
        self.on_link(bus, &LinkEvent::Received { frame: *frame, stamp: *stamp }, now, out);
    }

    /// The application made a request.
    fn on_request(
        &mut self,
        request: Self::Request,
        now: Instant,
        out: &mut Outbox<Self::Event, Self::Depth>,
    );

    /// Do what is due at `now`.
    fn poll(&mut self, now: Instant, out: &mut Outbox<Self::Event, Self::Depth>);

    /// When to call [`Node::poll`] next, `None`: not before another event.
    fn deadline(&self) -> Option<Instant>;

    /// Whether this frame may go out. Asked once for each, when it leaves the outbox; a frame that may not is reported as
    /// [`FailCause::OverBudget`].
    fn may_send(
        &mut self,
        _frame: &Frame,
        _now: Instant,
        _out: &mut Outbox<Self::Event, Self::Depth>,
    ) -> bool {
        true
    }

    /// Whether the exact end of this frame matters, received or transmitted: a search for its edges costs as much as ten frames.
    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool;
}

/// Where a node puts what it wants done.
pub struct Outbox<E, D: Depth = Usual> {
    commands: DequeInner<(Bus, BusCommand), D::Of<(Bus, BusCommand)>>,
    events: DequeInner<E, D::Of<E>>,
    overflows: u32,
    unsent: PerBus<u16>,
    has_clock_stepped: bool,
}

impl<E, D: Depth> Outbox<E, D> {
    /// Places that frames cannot take: joining and leaving a bus must always get through.
    const CONTROL_RESERVE: usize = {
        assert!(D::PLACES >= 8, "an outbox has at least 8 places");
        D::PLACES / 4
    };

    /// An empty outbox.
    #[inline]
    pub fn new() -> Self {
        Outbox {
            commands: D::deque(),
            events: D::deque(),
            overflows: 0,
            unsent: PerBus { nominal: 0, redundant: 0 },
            has_clock_stepped: false,
        }
    }

    /// Send a frame now or within `lifetime` of `now`; after that it is stale and dies.
    #[inline]
    pub fn send_for(&mut self, bus: Bus, frame: Frame, now: Instant, lifetime: Duration) {
        self.send_until(bus, frame, now + lifetime);
    }

    /// Send a frame before `expires`; from then on it is stale and dies.
    #[inline(never)] // sent from many places
    pub fn send_until(&mut self, bus: Bus, frame: Frame, expires: Instant) {
        self.command(bus, BusCommand::Send(Outgoing { frame, expires }));
    }

    /// Command a bus. The last quarter of the places is kept for commands other than sending.
    pub fn command(&mut self, bus: Bus, command: BusCommand) {
        let sends = matches!(command, BusCommand::Send(_));
        let reserve = if sends { Self::CONTROL_RESERVE } else { 0 };
        if self.commands.storage_len() + reserve >= D::PLACES
            || self.commands.push_back((bus, command)).is_err()
        {
            self.overflows = self.overflows.saturating_add(1);
            self.unsent[bus] = self.unsent[bus].saturating_add(u16::from(sends));
        }
    }

    /// Whether frames have at least half of it to themselves: commands that can wait should, if not.
    pub fn has_room(&self) -> bool {
        self.commands.storage_len() < D::PLACES / 2
    }

    /// Reports an event to the application.
    pub fn event(&mut self, event: E) {
        if self.events.push_back(event).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Reports an event, which is that the clock was set: who waits for a time looks again.
    pub fn step(&mut self, event: E) {
        self.has_clock_stepped = true;
        self.event(event);
    }

    /// Whether the clock was set since the last call.
    pub(crate) fn take_clock_stepped(&mut self) -> bool {
        core::mem::take(&mut self.has_clock_stepped)
    }

    /// The next command, in order.
    pub fn pop_command(&mut self) -> Option<(Bus, BusCommand)> {
        self.commands.pop_front()
    }

    /// Puts a command back behind all others.
    pub(crate) fn put_back(&mut self, bus: Bus, command: BusCommand) {
        if self.commands.push_back((bus, command)).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Commands that were not taken yet.
    pub(crate) fn commands(&self) -> usize {
        self.commands.storage_len()
    }

    /// Whether there is no command to take and no loss to report.
    #[inline]
    pub(crate) fn is_settled(&self) -> bool {
        self.commands.is_empty() && self.overflows == 0
    }

    /// Whether there are events to take.
    #[inline]
    pub(crate) fn has_events(&self) -> bool {
        !self.events.is_empty()
    }

    /// The next event, in order.
    pub fn pop_event(&mut self) -> Option<E> {
        self.events.pop_front()
    }

    /// Frames for `bus` lost since the last call because this outbox was full.
    pub fn take_unsent(&mut self, bus: Bus) -> u16 {
        core::mem::take(&mut self.unsent[bus])
    }

    /// Commands and events lost since the last call because this outbox was full.
    pub fn take_overflows(&mut self) -> u32 {
        core::mem::take(&mut self.overflows)
    }
}

impl<E, D: Depth> Default for Outbox<E, D> {
    fn default() -> Self {
        Self::new()
    }
}
