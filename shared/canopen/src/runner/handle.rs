//! Handle of a node, and its events, for an application.

use core::future::poll_fn;
use core::task::Poll;

use super::Platform;
use super::shared::register;
use super::storage::Core;
use super::{Clock, Diagnostics, Outside, SdoClient};
use crate::emcy::DeviceError;
use crate::node::{ClientNode, DeviceNode, Node};
use crate::types::{AbortCode, Address, Instant, NodeId};

/// Access of an application to its node, between two steps of the protocol.
///
/// [`read`](Handle::read) and [`update`](Handle::update) lend the objects of the application. What else a node has for its
/// application are methods by name: here, and for each type of node in the crate that has it. So an application cannot poll its
/// node, replace it, or hold it across a step.
pub struct Handle<B: Platform, N: Node> {
    pub(super) core: &'static Core<B, N>,
}

impl<B: Platform, N: Node> Clone for Handle<B, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: Platform, N: Node> Copy for Handle<B, N> {}

impl<B: Platform, N: Node> Handle<B, N> {
    pub(super) const fn new(core: &'static Core<B, N>) -> Self {
        Handle { core }
    }

    /// Returns the present instant of the node's clock.
    pub fn now(&self) -> Instant {
        self.core.clock.now()
    }

    /// Waits until `deadline`.
    ///
    /// # Cancel safety
    /// A dropped future has no effect.
    pub async fn wait_until(&self, deadline: Instant) {
        self.core.clock.at(deadline).await;
    }

    /// Returns the counters that a debugger or an emulator reads.
    pub fn diagnostics(&self) -> &'static Diagnostics {
        self.core.diagnostics
    }
}

impl<B: Platform, N: DeviceNode> Handle<B, N> {
    /// Lends the objects of the application to `read` and returns its result. Wakes no task.
    ///
    /// `read` cannot use a handle: see [`Outside`].
    pub fn read<R>(&self, read: impl FnOnce(&N::Device) -> R + Outside) -> R {
        self.core.lock(|shared| read(shared.node.device()))
    }

    /// Lends the objects of the application to `update`, which may change them, and returns its result. PDOs that are
    /// sent on events and have another content afterwards are queued before this returns.
    ///
    /// `update` cannot use a handle: see [`Outside`].
    pub fn update<R>(&self, update: impl FnOnce(&mut N::Device) -> R + Outside) -> R {
        self.core.lend(|node, now| node.change(now, update))
    }

    /// Writes an object as a client of the SDO server does. The same checks apply, and the services follow the
    /// new value.
    ///
    /// # Errors
    /// The abort code that a client would receive. Then nothing has changed.
    pub fn write(&self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
        let now = self.core.clock.now();
        self.core.lock(|shared| shared.step(now, |node, turn| node.write(at, value, turn)))
    }

    /// Reports by an EMCY that an error of the device appeared. Its manufacturer-specific field has the source of the
    /// error, then `info`. Does nothing while the error is active already.
    pub fn raise(&self, error: DeviceError, info: [u8; 4]) {
        self.core.lend(|node, _| node.raise(error, info));
    }

    /// Reports that an error of the device is gone. Does nothing if it is not active.
    pub fn clear(&self, error: DeviceError) {
        self.core.lend(|node, _| node.clear(error));
    }
}

impl<B: Platform, N: ClientNode> Handle<B, N> {
    /// Returns the SDO client of the node for the objects of another node. The node itself may use the client as well.
    pub const fn sdo(&self, node: NodeId) -> SdoClient<B, N> {
        SdoClient::new(self.core, node)
    }
}

/// Source of the events of a node: [`Events`], or what a test puts in its place. An application that takes its events from this
/// trait runs on a board and in a test.
pub trait EventSource {
    /// Event of the node.
    type Event;

    /// Waits for the next event.
    ///
    /// # Cancel safety
    /// A dropped future loses no event.
    fn next(&mut self) -> impl Future<Output = Self::Event>;
}

/// Events of a node for its application. A slow application loses events (counted in [`Diagnostics`]). The node
/// never waits.
pub struct Events<B: Platform, N: Node> {
    core: &'static Core<B, N>,
}

impl<B: Platform, N: Node> Events<B, N> {
    pub(super) const fn new(core: &'static Core<B, N>) -> Self {
        Events { core }
    }

    /// Waits for the next event.
    ///
    /// # Cancel safety
    /// A dropped future loses no event.
    pub async fn next(&mut self) -> N::Event {
        poll_fn(|context| {
            self.core.lock(|shared| match shared.out.pop_event() {
                Some(event) => Poll::Ready(event),
                None => {
                    register(&mut shared.listener, context);
                    Poll::Pending
                }
            })
        })
        .await
    }
}

impl<B: Platform, N: Node> EventSource for Events<B, N> {
    type Event = N::Event;

    #[inline]
    fn next(&mut self) -> impl Future<Output = N::Event> {
        Events::next(self)
    }
}
