//! Storage of a node on one bus.

use super::bus::BusState;
use super::storage::NodeStorage;
use super::{BusRunner, Connection, Diagnostics, DueRunner, Events, Handle, Platform};
use crate::node::Node;
use crate::types::Bus;

/// Storage as [`Resources`](super::Resources), for a node on one bus such as a
/// [`CanopenSlave`](crate::node::CanopenSlave).
pub struct Single<B: Platform, N: Node> {
    storage: NodeStorage<B, N, BusState<B::Port>>,
}

impl<B: Platform, N: Node> Single<B, N> {
    /// Makes storage without a node.
    pub const fn new() -> Self {
        Single { storage: NodeStorage::new() }
    }

    /// Makes the node and powers it on: sets the filters of the port by its dictionary, and starts it. The port
    /// must be off its bus.
    ///
    /// # Panics
    /// When called twice.
    #[inline(never)] // the stack on which a node is made is free again when its tasks run
    pub fn start(
        &'static self,
        node: impl FnOnce() -> N,
        connection: Connection<B::Port, B::Clock>,
        diagnostics: &'static Diagnostics,
    ) -> (Handle<B, N>, Events<B, N>, SingleRunners<B, N>) {
        let Connection { ports: port, clock } = connection;
        let state = || BusState::new(Bus::Nominal, port);
        let (core, state) = self.storage.start(node, state, clock, diagnostics);
        (
            Handle::new(core),
            Events::new(core),
            SingleRunners { bus: BusRunner::new(core, state), due: DueRunner::new(core) },
        )
    }
}

impl<B: Platform, N: Node> Default for Single<B, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Runners of a node on one bus, each for a task of its own.
pub struct SingleRunners<B: Platform, N: Node> {
    /// Runner for the task of the bus.
    pub bus: BusRunner<B, N>,
    /// Runner for the task of everything that is due by time.
    pub due: DueRunner<B, N>,
}
