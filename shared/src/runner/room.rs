//! Storage of a node and of what it works with, and access to it.

use core::cell::RefCell;
use core::hint::black_box;
use core::mem::MaybeUninit;

use static_cell::StaticCell;

use super::filters::fit;
use super::shared::Shared;
use super::{Diagnostics, Platform};
use crate::node::{Filters, Node};
use crate::time::Clock;

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

/// One line or two.
pub(super) trait Lines {
    fn set_filters(&mut self, filters: &Filters);
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

/// Makes a value in its place. The compiler omits the copy on the stack only if it knows nothing about the place
/// except that it is exclusive. Therefore this is a function of its own, and there are black boxes.
#[inline(never)]
fn make<T>(place: &mut MaybeUninit<T>, value: impl FnOnce() -> T) -> &mut T {
    place.write(value())
}
