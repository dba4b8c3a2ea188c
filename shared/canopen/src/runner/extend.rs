//! For tests, and for crates that extend nodes. An application needs none of it.
//!
//! [`WholeNode`] lends the whole node behind a [`Handle`]. [`Waiter`] and [`AtEnd`] are for futures of nodes that have more
//! than CANopen.

use core::future::poll_fn;
use core::pin::pin;
use core::task::{Poll, Waker};

use super::shared::Shared;
use super::storage::Core;
use super::{Clock, Handle, Platform};
use crate::node::Node;
use crate::types::{Duration, Instant};

/// Longest wait of a task without a place.
const LOOK: Duration = Duration::from_millis(100);

/// Access to the whole node behind a [`Handle`]: for tests and extensions, not for applications.
///
/// # Panics
/// Each of these methods panics when it is called from within a closure that has the node.
pub trait WholeNode {
    /// Type of the node.
    type Node: Node;

    /// Reads or changes the node at the present instant. What becomes due by it, such as a PDO, is done before this
    /// returns. A future that is dropped within `f` ends as it does elsewhere.
    fn with<R>(&self, f: impl FnOnce(&mut Self::Node, Instant) -> R) -> R;

    /// Reads the node. Wakes no task.
    fn inspect<R>(&self, f: impl FnOnce(&Self::Node) -> R) -> R;

    /// Makes a request to the node. The frames that it needs are sent in their turn.
    fn request(&self, request: <Self::Node as Node>::Request);
}

impl<B: Platform, N: Node> WholeNode for Handle<B, N> {
    type Node = N;

    fn with<R>(&self, f: impl FnOnce(&mut N, Instant) -> R) -> R {
        self.core.lend(f)
    }

    fn inspect<R>(&self, f: impl FnOnce(&N) -> R) -> R {
        self.core.lock(|shared| f(shared.node))
    }

    fn request(&self, request: N::Request) {
        let now = self.now();
        self.core.lock(|shared| shared.step(now, |node, turn| node.on_request(request, turn)));
    }
}

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

    /// Waits for the next signal, at most until `until`. Without a place it waits at most 100 ms: the task then checks for
    /// itself. It may end without a signal, too.
    ///
    /// # Cancel safety
    /// A dropped future has no effect.
    pub async fn wait_until(&self, until: Instant) {
        let clock = &self.core.clock;
        let until = if self.nth.is_some() { until } else { until.min(clock.now() + LOOK) };
        let mut timer = pin!(clock.at(until));
        let mut is_first = true;
        poll_fn(|context| {
            // Woken by a signal or by the timer.
            if !core::mem::take(&mut is_first) {
                return Poll::Ready(());
            }
            self.wake_by(context.waker());
            timer.as_mut().poll(context)
        })
        .await;
    }

    /// Lets the next signals wake this task.
    fn wake_by(&self, waker: &Waker) {
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
