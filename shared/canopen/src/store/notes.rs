//! Parameter whose newest value may be in the note beside the set.

use super::ParameterStore;
use crate::types::{Address, NodeId};

/// Meaning of the notes of a store: the value of one parameter of one byte. It is newer than the value in the set.
pub trait Notes {
    /// Address of the parameter.
    const PARAMETER: Address;

    /// Returns the value that `node` noted. `None` without a note of this node.
    fn noted(store: &dyn ParameterStore, node: NodeId) -> Option<u8>;
}

/// For a store without notes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoNotes;

impl Notes for NoNotes {
    const PARAMETER: Address = Address::new(0, 0);

    fn noted(_: &dyn ParameterStore, _: NodeId) -> Option<u8> {
        None
    }
}
