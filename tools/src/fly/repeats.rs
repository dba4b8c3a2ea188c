//! Emergency messages that a node repeats: one line in the story for all repeats in an interval.

use std::collections::BTreeMap;

use super::record::Node;

/// Content of an emergency message: error code, error register and details.
type Content = (u16, u8, [u8; 5]);

/// The last emergency message of each node, and its repeats.
#[derive(Clone, Debug, Default)]
pub struct Repeats(BTreeMap<Node, (Content, u32)>);

impl Repeats {
    /// Handles a message. Returns whether it equals the last one of its node.
    pub fn is_repeat(&mut self, node: Node, content: Content) -> bool {
        match self.0.get_mut(&node) {
            Some((last, repeats)) if *last == content => {
                *repeats += 1;
                true
            }
            _ => {
                self.0.insert(node, (content, 0));
                false
            }
        }
    }

    /// Returns the nodes with repeats since the last call, with error code and number.
    pub fn take(&mut self) -> Vec<(Node, u16, u32)> {
        let repeated = self.0.iter_mut().filter(|(_, (_, repeats))| *repeats > 0);
        repeated.map(|(node, ((code, ..), repeats))| (*node, *code, std::mem::take(repeats))).collect()
    }
}
