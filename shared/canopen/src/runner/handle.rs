//! Handle of a node, and its events, for an application.

use core::future::poll_fn;
use core::task::Poll;

use super::Platform;
use super::shared::register;
use super::storage::Core;
use super::{Clock, Diagnostics, SdoClient};
use crate::node::{ClientNode, DeviceNode, Node};
use crate::types::{AbortCode, Address, Instant, NodeId};

/// Access to a node between two steps of the protocol.
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

    /// Reads or changes the node at the present instant. What becomes due by it, such as a PDO, is done before this
    /// returns. A future that is dropped within `f` ends as it does elsewhere.
    ///
    /// # Panics
    /// When called from within itself.
    pub fn with<R>(&self, f: impl FnOnce(&mut N, Instant) -> R) -> R {
        self.core.lend(f)
    }

    /// Reads the node.
    ///
    /// # Panics
    /// When called from within [`Handle::with`].
    pub fn inspect<R>(&self, f: impl FnOnce(&N) -> R) -> R {
        self.core.lock(|shared| f(shared.node))
    }

    /// Makes a request to the node. The frames that it needs are sent in their turn.
    ///
    /// # Panics
    /// When called from within [`Handle::with`].
    pub fn request(&self, request: N::Request) {
        let now = self.core.clock.now();
        self.core.lock(|shared| shared.step(now, |node, turn| node.on_request(request, turn)));
    }

    /// Changes objects of the application. PDOs that are sent on events and have another content afterwards go
    /// out.
    ///
    /// # Panics
    /// When called from within [`Handle::with`] or itself.
    pub fn change<R>(&self, change: impl FnOnce(&mut N::Device) -> R) -> R
    where
        N: DeviceNode,
    {
        self.with(|node, now| node.change(now, change))
    }

    /// Writes an object as a client of the SDO server does. The same checks apply, and the services follow the
    /// new value.
    ///
    /// # Errors
    /// The abort code that a client would receive. Then nothing has changed.
    ///
    /// # Panics
    /// When called from within [`Handle::with`].
    pub fn write(&self, at: Address, value: &[u8]) -> Result<(), AbortCode>
    where
        N: DeviceNode,
    {
        let now = self.core.clock.now();
        self.core.lock(|shared| shared.step(now, |node, turn| node.write(at, value, turn)))
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
