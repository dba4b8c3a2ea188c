//! Interface between a node and its surroundings: events and time go in, commands and application events come out.
//!
//! A node is sans-IO. [`crate::runner`] is its async shell; tests call a node directly.

use heapless::deque::DequeInner;

use super::Turn;
use crate::link::Stamp;
use crate::link::depth::{Depth, Places};
use crate::link::port::{Filter, Health};
use crate::link::queue::Outgoing;
use crate::types::{Bus, Duration, Frame, Instant, PerBus};

/// Depth of the queues of a node with the whole protocol: commands in its outbox, frames in the transmit queue of
/// a bus, events that wait for the application.
pub const QUEUE_DEPTH: usize = 32;
/// [`Depth`] of a node with the whole protocol.
pub type FullDepth = Places<QUEUE_DEPTH>;
/// Greatest number of acceptance filters that a node asks a port for. A node keeps one bit of a word for each.
pub const MAX_FILTERS: usize = u32::BITS as usize;

/// Acceptance filters of a node. A full list may lack some. Then its port admits every frame.
pub type Filters = heapless::Vec<Filter, MAX_FILTERS>;

/// Report of a bus to its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum LinkEvent {
    /// A frame passed the filters.
    Received {
        /// Received frame, with its data.
        frame: Frame,
        /// End of the frame on the clock of the node.
        stamp: Stamp,
    },
    /// A frame of this node was acknowledged.
    Transmitted {
        /// Frame that was sent.
        frame: Frame,
        /// End of the frame on the clock of the node.
        stamp: Stamp,
    },
    /// A frame of this node was not sent.
    Failed {
        /// Frame that was not sent.
        frame: Frame,
        /// Reason why it was not sent.
        cause: FailCause,
    },
    /// Frames of this node were dropped before they reached the bus: the outbox was full.
    Unsent {
        /// Number of frames since the last report.
        frames: u16,
    },
    /// Received frames were lost before the node could see them.
    Overrun {
        /// Least number of frames since the last report.
        lost: u16,
    },
    /// The error state of the controller changed.
    Health(Health),
    /// The error counters of the controller moved since the last report. Reported before the next event of the
    /// controller.
    Counters(Health),
    /// The controller does not join or leave the bus: it is defective, or the bus is dominant all the time.
    Stalled,
}

/// Reason why a frame was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailCause {
    /// The node left the bus while the frame was pending.
    BusLeft,
    /// The lifetime of the frame ended.
    Expired,
    /// The transmit queue was full, or a frame that the network depends on displaced this one.
    QueueFull,
    /// The controller aborted the frame by itself (bus-off, reset).
    Aborted,
    /// The node sends too many frames: its [budget](crate::link::budget) is spent.
    OverBudget,
}

/// Command of a node to a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum BusCommand {
    /// Send a frame.
    Send(Outgoing),
    /// Abort everything pending, in queue and mailboxes, and stay on the bus (parallel access).
    Abandon,
    /// Take part in the bus.
    Join,
    /// Abort everything pending and listen: receive, but drive no dominant bit, not even an acknowledgement.
    Listen,
    /// Abort everything pending and leave the bus, silent (selective access).
    Leave,
    /// Begin recovery from bus-off.
    Recover,
    /// Admit other frames by one of the filters set at the start.
    Filter {
        /// Number of the filter.
        number: u8,
        /// Frames that the filter admits from now on.
        filter: Filter,
    },
}

/// Protocol node, master or slave, without input and output of its own.
pub trait Node: 'static {
    /// Event that the node reports to its application.
    type Event;
    /// Request that the application makes.
    type Request;
    /// Depth of the queues: [`FullDepth`], or less for a small node.
    type Depth: Depth;

    /// Returns the frames that the node receives, by its dictionary. Each bus has these filters before power-on.
    /// If a port has [too few](crate::link::port::CanPort::FILTERS), its last filters become one that admits
    /// every frame.
    fn filters(&self) -> Filters;

    /// Returns one of [`Node::filters`] as it is now, `None` above the last one. Each bus sets one filter again at
    /// each poll of its controller, because a bit may have flipped there (ECSS 6.10d).
    fn filter(&self, number: usize) -> Option<Filter> {
        self.filters().get(number).copied()
    }

    /// Powers the node on. Called once, before everything else.
    fn start(&mut self, turn: &mut Turn<'_, Self::Event, Self::Depth>);

    /// Handles an event of a bus.
    fn on_link(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn<'_, Self::Event, Self::Depth>);

    /// Handles a received frame: as [`LinkEvent::Received`], without copying the frame.
    fn on_received(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<'_, Self::Event, Self::Depth>,
    ) {
        self.on_link(bus, &LinkEvent::Received { frame: *frame, stamp: *stamp }, turn);
    }

    /// Handles a request of the application.
    fn on_request(&mut self, request: Self::Request, turn: &mut Turn<'_, Self::Event, Self::Depth>);

    /// Does what is due.
    fn poll(&mut self, turn: &mut Turn<'_, Self::Event, Self::Depth>);

    /// Returns when to call [`Node::poll`] next. `None`: not before another event.
    fn deadline(&self) -> Option<Instant>;

    /// Returns whether this frame may be sent. Called once for each frame, when it leaves the outbox. A refused
    /// frame is reported as [`FailCause::OverBudget`].
    fn charge(&mut self, _frame: &Frame, _turn: &mut Turn<'_, Self::Event, Self::Depth>) -> bool {
        true
    }

    /// Returns whether the node needs the exact end of this frame, received or transmitted. The search for its
    /// edges takes as much time as ten frames.
    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool;
}

/// Queue of the commands and events that a node hands out.
pub struct Outbox<E, D: Depth = FullDepth> {
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

    /// Makes an empty outbox.
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

    /// Sends a frame now or within `lifetime` of `now`. After that the frame is dropped.
    #[inline]
    pub fn send_for(&mut self, bus: Bus, frame: Frame, now: Instant, lifetime: Duration) {
        self.send_until(bus, frame, now + lifetime);
    }

    /// Sends a frame before `expires`. From then on the frame is dropped.
    #[inline(never)] // sent from many places
    pub fn send_until(&mut self, bus: Bus, frame: Frame, expires: Instant) {
        if !self.push_frame(bus, frame, expires) {
            self.overflows = self.overflows.saturating_add(1);
            self.unsent[bus] = self.unsent[bus].saturating_add(1);
        }
    }

    /// Sends a frame before `expires`, if there is room. Returns whether there was. The last quarter of the places is
    /// reserved for commands other than frames.
    #[inline(never)] // sent from many places
    pub fn offer(&mut self, bus: Bus, frame: Frame, expires: Instant) -> bool {
        self.push_frame(bus, frame, expires)
    }

    #[inline(always)] // a call more is 13 instructions (row `instructions.sdo_upload`)
    fn push_frame(&mut self, bus: Bus, frame: Frame, expires: Instant) -> bool {
        let has_room = self.commands.storage_len() + Self::CONTROL_RESERVE < D::PLACES;
        has_room && self.push(bus, BusCommand::Send(Outgoing { frame, expires }))
    }

    /// Sends a command to a bus.
    pub fn command(&mut self, bus: Bus, command: BusCommand) {
        match command {
            BusCommand::Send(Outgoing { frame, expires }) => self.send_until(bus, frame, expires),
            other => self.put_back(bus, other),
        }
    }

    #[inline]
    fn push(&mut self, bus: Bus, command: BusCommand) -> bool {
        self.commands.push_back((bus, command)).is_ok()
    }

    /// Returns whether frames still have at least half of the places. If not, commands that can wait should wait.
    pub fn has_room(&self) -> bool {
        self.commands.storage_len() < D::PLACES / 2
    }

    /// Reports an event to the application.
    pub fn event(&mut self, event: E) {
        if self.events.push_back(event).is_err() {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Reports an event that means a step of the clock. Tasks that wait for a time check it again.
    pub fn step(&mut self, event: E) {
        self.has_clock_stepped = true;
        self.event(event);
    }

    /// Returns whether the clock was set since the last call.
    pub(crate) fn take_clock_stepped(&mut self) -> bool {
        core::mem::take(&mut self.has_clock_stepped)
    }

    /// Takes the next command, in order.
    pub fn pop_command(&mut self) -> Option<(Bus, BusCommand)> {
        self.commands.pop_front()
    }

    /// Puts a command back behind all others.
    pub(crate) fn put_back(&mut self, bus: Bus, command: BusCommand) {
        if !self.push(bus, command) {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Commands that were not taken yet.
    pub(crate) fn commands(&self) -> usize {
        self.commands.storage_len()
    }

    /// Returns whether there is no command to take and no loss to report.
    #[inline]
    pub(crate) fn is_settled(&self) -> bool {
        self.commands.is_empty() && self.overflows == 0
    }

    /// Returns whether there are events to take.
    #[inline]
    pub(crate) fn has_events(&self) -> bool {
        !self.events.is_empty()
    }

    /// Takes the next event, in order.
    pub fn pop_event(&mut self) -> Option<E> {
        self.events.pop_front()
    }

    /// Returns the number of frames for `bus` lost since the last call because the outbox was full.
    pub fn take_unsent(&mut self, bus: Bus) -> u16 {
        core::mem::take(&mut self.unsent[bus])
    }

    /// Returns the number of commands and events lost since the last call because the outbox was full.
    pub fn take_overflows(&mut self) -> u32 {
        core::mem::take(&mut self.overflows)
    }
}

impl<E, D: Depth> Default for Outbox<E, D> {
    fn default() -> Self {
        Self::new()
    }
}
