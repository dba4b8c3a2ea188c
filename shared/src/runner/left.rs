//! What a future leaves to do when it is dropped while a step has the node.
//!
//! A future that holds a part of the node gives it back when it is dropped. An application can drop it within
//! [`Handle::with`](super::Handle::with), where the node is lent already. Then the part is given back at the end of that
//! step.

use core::cell::Cell;

use super::shared::{Shared, WAITERS};
use crate::node::Node;

/// Numbers of the parts. Those before are the places of the tasks that wait for a time of the spacecraft.
pub(super) const TRANSFER: usize = WAITERS;
pub(super) const MEASUREMENT: usize = WAITERS + 1;

/// Gives a part back. It gets the number of the part.
type GiveBack<N> = fn(&mut Shared<N>, usize);

/// Parts of a node to be given back at the end of the step.
pub(super) struct Left<N: Node> {
    parts: [Cell<Option<GiveBack<N>>>; WAITERS + 2],
    /// Whether there is one: nearly all calls leave nothing.
    is_any: Cell<bool>,
}

impl<N: Node> Left<N> {
    pub const fn new() -> Self {
        Left { parts: [const { Cell::new(None) }; WAITERS + 2], is_any: Cell::new(false) }
    }

    pub fn leave(&self, part: usize, give_back: GiveBack<N>) {
        if let Some(left) = self.parts.get(part) {
            left.set(Some(give_back));
            self.is_any.set(true);
        }
    }

    /// Gives back what was left.
    pub fn settle(&self, shared: &mut Shared<N>) {
        if self.is_any.take() {
            for (part, left) in self.parts.iter().enumerate() {
                if let Some(give_back) = left.take() {
                    give_back(shared, part);
                }
            }
        }
    }
}
