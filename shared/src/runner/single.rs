//! Storage of a node on one bus.

use core::cell::RefCell;
use core::hint::black_box;

use static_cell::StaticCell;

use super::bus::Line;
use super::resources::{Around, Core, make};
use super::shared::Shared;
use super::{BusRunner, DueRunner, Events, Handle, Platform, Telltale};
use crate::node::Node;
use crate::time::Clock;
use crate::types::Bus;

/// As [`Resources`](super::Resources), for a node on one bus, such as a [`CanopenSlave`](crate::node::CanopenSlave).
pub struct Single<B: Platform, N: Node> {
    node: StaticCell<N>,
    around: StaticCell<Around<B, N, Line<B::Port>>>,
}

impl<B: Platform, N: Node> Single<B, N> {
    /// Room for a node.
    pub const fn new() -> Self {
        Single { node: StaticCell::new(), around: StaticCell::new() }
    }

    /// Makes the node and powers it on: sets the filters of the port by its dictionary, and starts it. The port comes off its
    /// bus.
    ///
    /// # Panics
    /// When called twice.
    #[inline(never)] // the stack on which a node is made is free again when its tasks run
    pub fn start(
        &'static self,
        node: impl FnOnce() -> N,
        port: B::Port,
        clock: B::Clock,
        telltale: &'static Telltale,
    ) -> (Handle<B, N>, Events<B, N>, SingleRunners<B, N>) {
        let node = make(black_box(self.node.uninit()), node);
        let around = || Around {
            core: Core { shared: RefCell::new(Shared::new(node, telltale)), clock, telltale },
            lines: Line::new(Bus::Nominal, port),
        };
        let Around { core, lines } = make(black_box(self.around.uninit()), around);
        let shared = core.shared.get_mut();
        lines.set_filters(&shared.node.filters());
        shared.power_on(core.clock.now());
        let core = &*core;
        (
            Handle::new(core),
            Events::new(core),
            SingleRunners { bus: BusRunner::new(core, lines), due: DueRunner::new(core) },
        )
    }
}

impl<B: Platform, N: Node> Default for Single<B, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// What the tasks of a node on one bus run.
pub struct SingleRunners<B: Platform, N: Node> {
    /// For the task of the bus.
    pub bus: BusRunner<B, N>,
    /// For the task of what is due by time.
    pub due: DueRunner<B, N>,
}
