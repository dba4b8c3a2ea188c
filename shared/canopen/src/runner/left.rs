//! What a future leaves to do when it is dropped while a step has the node.
//!
//! A future that holds a part of the node gives it back when it is dropped. An application can drop it within
//! [`WholeNode::with`](super::extend::WholeNode::with), where the node is lent already. Then the part is given back at the end of that
//! step.

use core::cell::Cell;

use super::shared::{Shared, WAITERS};
use crate::node::Node;

/// Number of the part that is the SDO client. Those before are the places of the tasks that wait for a signal.
pub(super) const TRANSFER: usize = WAITERS;

/// Gives a part back. It gets the number of the part.
type GiveBack<N> = fn(&mut Shared<N>, usize);

/// Parts of a node to be given back at the end of the step.
pub(super) struct Left<N: Node> {
    parts: [Cell<Option<GiveBack<N>>>; WAITERS + 1],
    /// What an extension of the node does at its end.
    end: Cell<Option<fn(&mut N)>>,
    /// Whether there is one: nearly all calls leave nothing.
    is_any: Cell<bool>,
}

impl<N: Node> Left<N> {
    pub const fn new() -> Self {
        Left {
            parts: [const { Cell::new(None) }; WAITERS + 1],
            end: Cell::new(None),
            is_any: Cell::new(false),
        }
    }

    pub fn leave(&self, part: usize, give_back: GiveBack<N>) {
        if let Some(left) = self.parts.get(part) {
            left.set(Some(give_back));
            self.is_any.set(true);
        }
    }

    pub fn leave_end(&self, end: fn(&mut N)) {
        self.end.set(Some(end));
        self.is_any.set(true);
    }

    /// Gives back what was left.
    pub fn settle(&self, shared: &mut Shared<N>) {
        if self.is_any.take() {
            for (part, left) in self.parts.iter().enumerate() {
                if let Some(give_back) = left.take() {
                    give_back(shared, part);
                }
            }
            if let Some(end) = self.end.take() {
                end(shared.node);
            }
        }
    }
}
