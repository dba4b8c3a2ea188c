//! Storage of a node, and its start.

use super::bus::BusState;
use super::storage::NodeStorage;
use super::{BusRunner, Connection, Diagnostics, DueRunner, Events, Handle, Platform};
use crate::node::Node;
use crate::types::{Bus, PerBus};

/// Storage of a node: the node, its queues, both ports and the clock. The user owns it in a `static`.
pub struct Resources<B: Platform, N: Node> {
    storage: NodeStorage<B, N, PerBus<BusState<B::Port>>>,
}

impl<B: Platform, N: Node> Resources<B, N> {
    /// Makes storage without a node.
    pub const fn new() -> Self {
        Resources { storage: NodeStorage::new() }
    }

    /// Makes the node and powers it on: sets the filters of both ports by its dictionary, and starts it. The ports
    /// must be off their buses.
    ///
    /// The node takes part in its buses as soon as each of the runners has a task.
    ///
    /// # Panics
    /// When called twice.
    #[inline(never)] // the stack on which a node is made is free again when its tasks run
    pub fn start(
        &'static self,
        node: impl FnOnce() -> N,
        connection: Connection<PerBus<B::Port>, B::Clock>,
        diagnostics: &'static Diagnostics,
    ) -> (Handle<B, N>, Events<B, N>, Runners<B, N>) {
        let Connection { ports, clock } = connection;
        let buses = || PerBus {
            nominal: BusState::new(Bus::Nominal, ports.nominal),
            redundant: BusState::new(Bus::Redundant, ports.redundant),
        };
        let (core, buses) = self.storage.start(node, buses, clock, diagnostics);
        let runners = Runners {
            nominal: BusRunner::new(core, &mut buses.nominal),
            redundant: BusRunner::new(core, &mut buses.redundant),
            due: DueRunner::new(core),
        };
        (Handle::new(core), Events::new(core), runners)
    }
}

impl<B: Platform, N: Node> Default for Resources<B, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Runners of a node on two buses, each for a task of its own.
pub struct Runners<B: Platform, N: Node> {
    /// Runner for the task of the nominal bus.
    pub nominal: BusRunner<B, N>,
    /// Runner for the task of the redundant bus.
    pub redundant: BusRunner<B, N>,
    /// Runner for the task of everything that is due by time.
    pub due: DueRunner<B, N>,
}
