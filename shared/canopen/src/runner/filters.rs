//! Acceptance filters of a port: fitted to their number, and set again in turn.

use crate::link::port::{CanPort, Filter};
use crate::node::{Filters, MAX_FILTERS, Node};

/// Keeps the filters that a port has. If those of the node are more, the last one admits every frame.
#[inline]
pub(super) fn fit<P: CanPort>(filters: &mut Filters) {
    const { assert!(P::FILTERS > 0 && P::FILTERS <= MAX_FILTERS, "a port has 1 to 32 filters") };
    if let Some(last) = filters.get_mut(P::FILTERS - 1) {
        *last = Filter::ALL;
        filters.truncate(P::FILTERS);
    }
}

/// Sets a filter. If the node has as many filters as the port, or more, the last one of the port admits every frame.
pub(super) fn set<P: CanPort>(port: &mut P, number: u8, filter: Filter) {
    let last = P::FILTERS - 1;
    if usize::from(number) <= last {
        port.set_filter(number, if usize::from(number) < last { filter } else { Filter::ALL });
    }
}

/// Sets the filters of a port anew, as a bit may have flipped in the controller. Each bus does so for
/// itself, at a moment of its own, as long steps delay frames (row `rx.inside_look`).
#[derive(Default)]
pub(super) struct Refresh {
    next: u8,
}

impl Refresh {
    /// Sets the next filter as the node has it now.
    pub fn step<P: CanPort, N: Node>(&mut self, port: &mut P, node: &N) {
        match node.filter(self.next.into()) {
            Some(filter) => {
                set(port, self.next, filter);
                self.next = self.next.wrapping_add(1);
            }
            None => self.next = 0,
        }
    }
}
