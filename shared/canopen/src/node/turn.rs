//! One step of a node, and the deadlines of its parts.
//!
//! A node has many parts with deadlines, and it has to know the earliest of them at each frame. [`Wakes`] has one instant,
//! before which nothing is due. A part is changed through [`Timed`], which lowers that instant. So it may be too early, but
//! never too late, and a frame compares it once, however many parts there are. A run of the node computes it anew.

use core::ops::Deref;

use super::messages::FullDepth;
use super::outbox::Outbox;
use crate::link::depth::Depth;
use crate::types::Instant;

/// One step of a node: its time, and where it puts what it wants.
pub struct Turn<'a, E, D: Depth = FullDepth> {
    /// Deadlines up to here are due. It may be before `now`: a frame is judged by its end.
    pub until: Instant,
    /// Present instant on the clock of the node.
    pub now: Instant,
    /// Takes commands to the buses and events for the application.
    pub out: &'a mut Outbox<E, D>,
}

impl<'a, E, D: Depth> Turn<'a, E, D> {
    /// Begins a step at `now`.
    pub fn new(now: Instant, out: &'a mut Outbox<E, D>) -> Self {
        Turn { until: now, now, out }
    }
}

/// Instant before which nothing is due in a node.
#[derive(Debug)]
pub struct Wakes(Instant);

impl Wakes {
    /// Everything may be due.
    pub(crate) const fn at_once() -> Self {
        Wakes(Instant::ZERO)
    }

    /// Nothing is due.
    pub const fn never() -> Self {
        Wakes(Instant::NEVER)
    }

    /// Returns whether something may be due at `until`.
    pub fn is_due(&self, until: Instant) -> bool {
        until >= self.0
    }

    // Rows `instructions.sdo_upload` and `size.pyboard-v11.slave.flash`: on a chip of 32 bits a call is shorter.
    #[cfg_attr(not(target_os = "none"), inline)]
    #[cfg_attr(target_os = "none", inline(never))]
    fn lower(&mut self, deadline: Instant) {
        if deadline < self.0 {
            self.0 = deadline;
        }
    }

    /// Returns the instant, `None` if nothing is due.
    pub fn deadline(&self) -> Option<Instant> {
        (self.0 < Instant::NEVER).then_some(self.0)
    }

    /// Notes a deadline, if there is one.
    pub fn note(&mut self, deadline: Option<Instant>) {
        self.lower(deadline.unwrap_or(Instant::NEVER));
    }

    /// Notes the earliest deadline of all parts, after each of them has run.
    pub fn set(&mut self, deadline: Option<Instant>) {
        self.0 = deadline.unwrap_or(Instant::NEVER);
    }
}

/// Part of a node with deadlines.
pub trait Part {
    /// Returns when something is due at the earliest, whatever the other parts are like.
    fn earliest(&self) -> Option<Instant>;
}

/// Part of a node that is changed together with the instant at which the node runs next.
#[derive(Debug)]
pub struct Timed<T>(T);

impl<T: Part> Timed<T> {
    /// Makes the part, which is not due before it is changed.
    pub const fn new(part: T) -> Self {
        Timed(part)
    }

    /// Lends the part for a change. The node runs at the end of its step.
    pub fn change(&mut self, wakes: &mut Wakes) -> &mut T {
        wakes.0 = Instant::ZERO;
        &mut self.0
    }

    /// Changes the part. The node runs at the deadline that the part has afterwards. It is for changes that are frequent and
    /// seldom make something due at once.
    #[inline(always)] // row `instructions.sdo_upload`
    pub fn step<R>(&mut self, wakes: &mut Wakes, step: impl FnOnce(&mut T) -> R) -> R {
        let result = step(&mut self.0);
        self.settle(wakes);
        result
    }

    /// Lets the node run at the deadline of the part, after a change through [`Timed::no_sooner`] that may have made it
    /// earlier after all.
    pub fn settle(&self, wakes: &mut Wakes) {
        wakes.lower(self.0.earliest().unwrap_or(Instant::NEVER));
    }

    /// Lends the part for a change that makes nothing due earlier, or within a run of the node, which looks at all deadlines
    /// at its end.
    pub fn no_sooner(&mut self) -> &mut T {
        &mut self.0
    }
}

impl<T> Deref for Timed<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}
