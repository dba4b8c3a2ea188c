//! Extension of a [`Handle`]: for nodes that have more than CANopen.

use core::task::Waker;

use super::shared::Shared;
use super::storage::Core;
use super::{Handle, Platform};
use crate::node::Node;

/// Place among the four tasks that the node wakes at each [signal](crate::node::Outbox::signal). It is free again when this
/// is dropped.
pub struct Waiter<B: Platform, N: Node> {
    core: &'static Core<B, N>,
    nth: Option<usize>,
}

impl<B: Platform, N: Node> Waiter<B, N> {
    /// Takes a place, if one is free.
    pub fn take(handle: Handle<B, N>) -> Self {
        let core = handle.core;
        let nth = core.lock(|shared| {
            let nth = shared.waiters.iter().position(Option::is_none)?;
            // Reserved: the task waits soon.
            *shared.waiters.get_mut(nth)? = Some(Waker::noop().clone());
            Some(nth)
        });
        Waiter { core, nth }
    }

    /// Returns whether a place was free. Without one the task has to check for itself, from time to time.
    pub const fn has_place(&self) -> bool {
        self.nth.is_some()
    }

    /// Lets the next signals wake this task.
    pub fn wake_by(&self, waker: &Waker) {
        self.core.lock(|shared| {
            if let Some(slot) = self.nth.and_then(|nth| shared.waiters.get_mut(nth)) {
                *slot = Some(waker.clone());
            }
        });
    }
}

impl<B: Platform, N: Node> Drop for Waiter<B, N> {
    fn drop(&mut self) {
        let Some(nth) = self.nth else { return };
        self.core.give_back(nth, Shared::free);
    }
}

/// Calls a function of the node when it is dropped, or at the end of the call that has the node then. A node has one at a time.
pub struct AtEnd<B: Platform, N: Node> {
    core: &'static Core<B, N>,
    end: fn(&mut N),
}

impl<B: Platform, N: Node> AtEnd<B, N> {
    /// Will call `end`.
    pub const fn new(handle: Handle<B, N>, end: fn(&mut N)) -> Self {
        AtEnd { core: handle.core, end }
    }
}

impl<B: Platform, N: Node> Drop for AtEnd<B, N> {
    fn drop(&mut self) {
        self.core.end(self.end);
    }
}
