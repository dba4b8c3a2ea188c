//! Storage of a node, and how it is powered on.

use core::cell::RefCell;

use super::bus::Line;
use super::shared::Shared;
use super::{BusRunner, DueRunner, Events, Handle, Telltale};
use crate::link::port::CanPort;
use crate::node::Node;
use crate::time::Clock;
use crate::types::{Bus, PerBus};

/// A board, by the types that the protocol needs of it.
pub trait Platform {
    /// Its CAN controllers.
    type Port: CanPort;
    /// Its time.
    type Clock: Clock;
}

/// Everything that lives as long as a node: the node, its queues, both ports and the clock.
///
/// The user decides where: in a `static` (`StaticCell`) on a board.
pub struct Resources<B: Platform, N: Node> {
    core: Core<B, N>,
    lines: PerBus<Line<B::Port>>,
}

/// What all tasks of a node share.
pub(super) struct Core<B: Platform, N: Node> {
    pub shared: RefCell<Shared<N>>,
    pub clock: B::Clock,
    pub telltale: &'static Telltale,
}

impl<B: Platform, N: Node> Core<B, N> {
    /// Works on the node in place.
    #[inline]
    pub fn lock<R>(&self, f: impl FnOnce(&mut Shared<N>) -> R) -> R {
        f(&mut self.shared.borrow_mut())
    }
}

impl<B: Platform, N: Node> Resources<B, N> {
    /// A node before power-on. The ports come off their buses.
    #[inline] // made where it stays: each copy of a master is 15 kB of a stack
    pub fn new(node: N, ports: PerBus<B::Port>, clock: B::Clock, telltale: &'static Telltale) -> Self {
        Resources {
            core: Core { shared: RefCell::new(Shared::new(node, telltale)), clock, telltale },
            lines: PerBus {
                nominal: Line::new(Bus::Nominal, ports.nominal),
                redundant: Line::new(Bus::Redundant, ports.redundant),
            },
        }
    }

    /// Powers the node on: sets the filters of both ports by its dictionary, and starts it.
    ///
    /// It takes part in its buses as soon as each of the runners has a task.
    ///
    /// # Panics
    /// When called twice.
    pub fn start(&mut self) -> (Handle<'_, B, N>, Events<'_, B, N>, Runners<'_, B, N>) {
        let shared = self.core.shared.get_mut();
        let filters = shared.node.filters();
        self.lines.nominal.set_filters(&filters);
        self.lines.redundant.set_filters(&filters);
        shared.power_on(self.core.clock.now());
        let core = &self.core;
        let runners = Runners {
            nominal: BusRunner::new(core, &mut self.lines.nominal),
            redundant: BusRunner::new(core, &mut self.lines.redundant),
            due: DueRunner::new(core),
        };
        (Handle::new(core), Events::new(core), runners)
    }
}

/// What the tasks of a node run.
pub struct Runners<'a, B: Platform, N: Node> {
    /// For the task of the nominal bus.
    pub nominal: BusRunner<'a, B, N>,
    /// For the task of the redundant bus.
    pub redundant: BusRunner<'a, B, N>,
    /// For the task of what is due by time.
    pub due: DueRunner<'a, B, N>,
}
