//! Commands and events on their way out of a node.

use super::messages::{BusCommand, FullDepth};
use crate::link::depth::Depth;
use crate::link::queue::Outgoing;
use crate::link::ring::Ring;
use crate::types::{Bus, Duration, Frame, Instant, PerBus};

/// Queue of the commands and events that a node hands out.
pub struct Outbox<E, D: Depth = FullDepth> {
    commands: Ring<(Bus, BusCommand), D>,
    events: Ring<E, D>,
    overflows: u32,
    unsent: PerBus<u16>,
    has_signal: bool,
    done_until: Instant,
}

impl<E, D: Depth> Outbox<E, D> {
    /// Places that frames cannot take: joining and leaving a bus must always get through.
    const CONTROL_RESERVE: usize = {
        assert!(D::PLACES >= 8, "an outbox has at least 8 places");
        D::PLACES / 4
    };

    /// Makes an empty outbox.
    pub fn new() -> Self {
        Outbox {
            commands: Ring::new(),
            events: Ring::new(),
            overflows: 0,
            unsent: PerBus { nominal: 0, redundant: 0 },
            has_signal: false,
            done_until: Instant::ZERO,
        }
    }

    /// Notes that the node has done everything that was due until `until`.
    pub fn note_done(&mut self, until: Instant) {
        self.done_until = until;
    }

    /// Returns the instant of the last call of [`Outbox::note_done`].
    pub(crate) fn done_until(&self) -> Instant {
        self.done_until
    }

    /// Sends a frame now or within `lifetime` of `now`. After that the frame is dropped.
    pub fn send_for(&mut self, bus: Bus, frame: Frame, now: Instant, lifetime: Duration) {
        self.send_until(bus, frame, now + lifetime);
    }

    /// Sends a frame before `expires`. From then on the frame is dropped.
    pub fn send_until(&mut self, bus: Bus, frame: Frame, expires: Instant) {
        if !self.push_frame(bus, frame, expires) {
            self.overflows = self.overflows.saturating_add(1);
            self.unsent[bus] = self.unsent[bus].saturating_add(1);
        }
    }

    /// Sends a frame before `expires`, if there is room. Returns whether there was. The last quarter of the places is
    /// reserved for commands other than frames.
    pub fn offer(&mut self, bus: Bus, frame: Frame, expires: Instant) -> bool {
        self.push_frame(bus, frame, expires)
    }

    #[inline(always)] // a call more is 13 instructions (row `instructions.sdo_upload`)
    fn push_frame(&mut self, bus: Bus, frame: Frame, expires: Instant) -> bool {
        let has_room = self.commands.len() + Self::CONTROL_RESERVE < D::PLACES;
        has_room && self.push(bus, BusCommand::Send(Outgoing { frame, expires }))
    }

    /// Sends a command to a bus.
    pub fn command(&mut self, bus: Bus, command: BusCommand) {
        match command {
            BusCommand::Send(Outgoing { frame, expires }) => self.send_until(bus, frame, expires),
            other => self.put_back(bus, other),
        }
    }

    fn push(&mut self, bus: Bus, command: BusCommand) -> bool {
        self.commands.push((bus, command))
    }

    /// Returns whether frames still have at least half of the places. If not, commands that can wait should wait.
    pub fn has_room(&self) -> bool {
        self.commands.len() < D::PLACES / 2
    }

    /// Reports an event to the application.
    pub fn event(&mut self, event: E) {
        if !self.events.push(event) {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Reports an event that wakes the tasks which wait for a [signal](crate::runner::extend::Waiter), too.
    pub fn signal(&mut self, event: E) {
        self.has_signal = true;
        self.event(event);
    }

    /// Returns whether there was a signal since the last call.
    pub(crate) fn take_signal(&mut self) -> bool {
        core::mem::take(&mut self.has_signal)
    }

    /// Takes the next command, in order.
    pub fn pop_command(&mut self) -> Option<(Bus, BusCommand)> {
        self.commands.pop()
    }

    /// Puts a command back behind all others.
    pub(crate) fn put_back(&mut self, bus: Bus, command: BusCommand) {
        if !self.push(bus, command) {
            self.overflows = self.overflows.saturating_add(1);
        }
    }

    /// Commands that were not taken yet.
    pub(crate) fn commands(&self) -> usize {
        self.commands.len()
    }

    /// Returns whether there is no command to take and no loss to report.
    pub(crate) fn is_settled(&self) -> bool {
        self.commands.is_empty() && self.overflows == 0
    }

    /// Returns whether there are events to take.
    pub(crate) fn has_events(&self) -> bool {
        !self.events.is_empty()
    }

    /// Takes the next event, in order.
    pub fn pop_event(&mut self) -> Option<E> {
        self.events.pop()
    }

    /// Returns the number of frames for `bus` lost since the last call because the outbox was full.
    pub(crate) fn take_unsent(&mut self, bus: Bus) -> u16 {
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
