//! Interface between a node and its surroundings: events and time go in, commands and application events come out.
//!
//! A node is sans-IO. [`crate::runner`] is its async shell; tests call a node directly.

use super::messages::{Filters, LinkEvent};
use super::turn::Turn;
use crate::link::Stamp;
use crate::link::depth::Depth;
use crate::link::port::Filter;
use crate::types::{Bus, Frame, Instant};

/// Protocol node, master or slave, without input and output of its own.
pub trait Node: 'static {
    /// Event that the node reports to its application.
    type Event;
    /// Request that the application makes.
    type Request;
    /// Depth of the queues: [`FullDepth`](super::FullDepth), or less for a small node.
    type Depth: Depth;

    /// Returns the frames that the node receives, by its dictionary. Each bus has these filters before power-on.
    /// If a port has [too few](crate::link::port::CanPort::FILTERS), its last filters become one that admits
    /// every frame.
    fn filters(&self) -> Filters;

    /// Returns one of [`Node::filters`] as it is now, `None` above the last one. Each bus sets one filter again at
    /// each poll of its controller, because a bit may have flipped there.
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

    /// Returns whether everything that the node sends periodically was sent when it was due: its heartbeat and SYNC. A node
    /// that must not send is on schedule.
    fn is_on_schedule(&self, _now: Instant) -> bool {
        true
    }

    /// Returns whether this frame may be sent. Called once for each frame, when it leaves the outbox. A refused
    /// frame is reported as [`FailCause::OverBudget`](super::FailCause::OverBudget).
    fn charge(&mut self, _frame: &Frame, _turn: &mut Turn<'_, Self::Event, Self::Depth>) -> bool {
        true
    }

    /// Returns whether the node needs the exact end of this frame, received or transmitted. The search for its
    /// edges takes as much time as ten frames.
    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool;
}
