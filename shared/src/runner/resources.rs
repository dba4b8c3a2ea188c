//! Storage of a node, and its start.

use core::cell::RefCell;
use core::hint::black_box;
use core::mem::MaybeUninit;

use static_cell::StaticCell;

use super::bus::Line;
use super::filters::fit;
use super::shared::Shared;
use super::{BusRunner, Diagnostics, DueRunner, Events, Handle};
use crate::link::port::CanPort;
use crate::node::{Filters, Node};
use crate::time::Clock;
use crate::types::{Bus, PerBus};

/// Board, by the types that the protocol needs.
pub trait Platform: 'static {
    /// Type of its CAN controllers.
    type Port: CanPort;
    /// Type of its clock.
    type Clock: Clock;
}

/// Storage of a node: the node, its queues, both ports and the clock. The user owns it in a `static`.
pub struct Resources<B: Platform, N: Node> {
    room: Room<B, N, PerBus<Line<B::Port>>>,
}

/// Storage of a node and of what it works with.
pub(super) struct Room<B: Platform, N: Node, L> {
    // Apart: a node is large, and is made where it stays.
    node: StaticCell<N>,
    around: StaticCell<Around<B, N, L>>,
}

/// Surroundings of a node. `L`: the lines of its buses.
struct Around<B: Platform, N: Node, L> {
    core: Core<B, N>,
    lines: L,
}

/// One line or two.
pub(super) trait Lines {
    fn set_filters(&mut self, filters: &Filters);
}

impl<P: CanPort> Lines for PerBus<Line<P>> {
    fn set_filters(&mut self, filters: &Filters) {
        self.nominal.set_filters(filters);
        self.redundant.set_filters(filters);
    }
}

impl<B: Platform, N: Node, L: Lines> Around<B, N, L> {
    #[inline(never)] // its stack is not that on which a node is made
    fn power_on(&mut self) {
        let Around { core, lines } = self;
        let shared = core.shared.get_mut();
        let mut filters = shared.node.filters();
        fit::<B::Port>(&mut filters);
        lines.set_filters(&filters);
        shared.power_on(core.clock.now());
    }
}

impl<B: Platform, N: Node, L: Lines> Room<B, N, L> {
    pub const fn new() -> Self {
        Room { node: StaticCell::new(), around: StaticCell::new() }
    }

    /// Makes everything in its place and powers the node on.
    #[inline(always)] // its callers are not inlined
    pub fn start(
        &'static self,
        node: impl FnOnce() -> N,
        lines: impl FnOnce() -> L,
        clock: B::Clock,
        diagnostics: &'static Diagnostics,
    ) -> (&'static Core<B, N>, &'static mut L) {
        let node = make(black_box(self.node.try_uninit().unwrap()), node);
        let around = || Around {
            core: Core { shared: RefCell::new(Shared::new(node, diagnostics)), clock, diagnostics },
            lines: lines(),
        };
        let around = make(black_box(self.around.try_uninit().unwrap()), around);
        around.power_on();
        (&around.core, &mut around.lines)
    }
}

/// Data that all tasks of a node share.
pub(super) struct Core<B: Platform, N: Node> {
    pub shared: RefCell<Shared<N>>,
    pub clock: B::Clock,
    pub diagnostics: &'static Diagnostics,
}

impl<B: Platform, N: Node> Core<B, N> {
    /// Calls `f` with the node in its place.
    #[inline]
    pub fn lock<R>(&self, f: impl FnOnce(&mut Shared<N>) -> R) -> R {
        f(&mut self.shared.borrow_mut())
    }
}

impl<B: Platform, N: Node> Resources<B, N> {
    /// Makes storage without a node.
    pub const fn new() -> Self {
        Resources { room: Room::new() }
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
        ports: PerBus<B::Port>,
        clock: B::Clock,
        diagnostics: &'static Diagnostics,
    ) -> (Handle<B, N>, Events<B, N>, Runners<B, N>) {
        let lines = || PerBus {
            nominal: Line::new(Bus::Nominal, ports.nominal),
            redundant: Line::new(Bus::Redundant, ports.redundant),
        };
        let (core, lines) = self.room.start(node, lines, clock, diagnostics);
        let runners = Runners {
            nominal: BusRunner::new(core, &mut lines.nominal),
            redundant: BusRunner::new(core, &mut lines.redundant),
            due: DueRunner::new(core),
        };
        (Handle::new(core), Events::new(core), runners)
    }
}

/// Makes a value in its place. The compiler omits the copy on the stack only if it knows nothing about the place
/// except that it is exclusive. Therefore this is a function of its own, and there are black boxes.
#[inline(never)]
fn make<T>(place: &mut MaybeUninit<T>, value: impl FnOnce() -> T) -> &mut T {
    place.write(value())
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
