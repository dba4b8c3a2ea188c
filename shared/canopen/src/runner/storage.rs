//! Storage of a node and of what it works with, and access to it.

use core::cell::RefCell;
use core::hint::black_box;
use core::mem::MaybeUninit;

use static_cell::StaticCell;

use super::Clock;
use super::filters::fit;
use super::left::Left;
use super::shared::Shared;
use super::{Diagnostics, Platform};
use crate::node::{Filters, Node};
use crate::types::Instant;

/// Storage of a node and of what it works with.
pub(super) struct NodeStorage<B: Platform, N: Node, L> {
    // Apart: a node is large, and is made where it stays.
    node: StaticCell<N>,
    surroundings: StaticCell<Surroundings<B, N, L>>,
}

/// Surroundings of a node. `L`: the state of its bus, or of both.
struct Surroundings<B: Platform, N: Node, L> {
    core: Core<B, N>,
    buses: L,
}

impl<B: Platform, N: Node, L: BusStates> Surroundings<B, N, L> {
    #[inline(never)] // its stack is not that on which a node is made
    fn power_on(&mut self) {
        let Surroundings { core, buses } = self;
        let shared = core.shared.get_mut();
        let mut filters = shared.node.filters();
        fit::<B::Port>(&mut filters);
        buses.set_filters(&filters);
        shared.power_on(core.clock.now());
    }
}

impl<B: Platform, N: Node, L: BusStates> NodeStorage<B, N, L> {
    pub const fn new() -> Self {
        NodeStorage { node: StaticCell::new(), surroundings: StaticCell::new() }
    }

    /// Makes everything in its place and powers the node on.
    #[inline(always)] // its callers are not inlined
    pub fn start(
        &'static self,
        node: impl FnOnce() -> N,
        buses: impl FnOnce() -> L,
        clock: B::Clock,
        diagnostics: &'static Diagnostics,
    ) -> (&'static Core<B, N>, &'static mut L) {
        let node = make(black_box(self.node.try_uninit().unwrap()), node);
        let surroundings = || Surroundings {
            core: Core {
                shared: RefCell::new(Shared::new(node, diagnostics)),
                left: Left::new(),
                clock,
                diagnostics,
            },
            buses: buses(),
        };
        let surroundings = make(black_box(self.surroundings.try_uninit().unwrap()), surroundings);
        surroundings.power_on();
        (&surroundings.core, &mut surroundings.buses)
    }
}

/// State of one bus or of two.
pub(super) trait BusStates {
    fn set_filters(&mut self, filters: &Filters);
}

/// Data that all tasks of a node share.
pub(super) struct Core<B: Platform, N: Node> {
    pub shared: RefCell<Shared<N>>,
    pub left: Left<N>,
    pub clock: B::Clock,
    pub diagnostics: &'static Diagnostics,
}

impl<B: Platform, N: Node> Core<B, N> {
    /// Calls `f` with the node in its place.
    #[inline]
    pub fn lock<R>(&self, f: impl FnOnce(&mut Shared<N>) -> R) -> R {
        f(&mut self.shared.borrow_mut())
    }

    /// Lends the node to code of the application, which may change it and may drop futures. Then does what has become
    /// due.
    pub fn lend<R>(&self, f: impl FnOnce(&mut N, Instant) -> R) -> R {
        let now = self.clock.now();
        self.lock(|shared| {
            let result = f(shared.node, now);
            self.end_call(shared, now);
            result
        })
    }

    /// Gives a part of the node back: at once, or at the end of the call that has the node.
    pub fn give_back(&self, part: usize, give_back: fn(&mut Shared<N>, usize)) {
        self.left.leave(part, give_back);
        self.settle_left();
    }

    /// Calls a function of the node: at once, or at the end of the call that has the node.
    pub fn end(&self, end: fn(&mut N)) {
        self.left.leave_end(end);
        self.settle_left();
    }

    fn settle_left(&self) {
        if let Ok(mut shared) = self.shared.try_borrow_mut() {
            self.end_call(&mut shared, self.clock.now());
        }
    }

    #[inline(never)] // once for all closures of an application
    fn end_call(&self, shared: &mut Shared<N>, now: Instant) {
        self.left.settle(shared);
        shared.finish(now);
    }
}

/// Makes a value in its place. The compiler omits the copy on the stack only if it knows nothing about the place
/// except that it is exclusive. Therefore this is a function of its own, and there are black boxes.
#[inline(never)]
fn make<T>(place: &mut MaybeUninit<T>, value: impl FnOnce() -> T) -> &mut T {
    place.write(value())
}
