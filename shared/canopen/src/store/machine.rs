//! Saves and loads of a parameter set, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::limit::SaveLimit;
pub use super::notes::{NoNotes, Notes};
pub use super::save::Save;
pub use super::set::{Apply, MAX_VALUE, load};
pub use super::storage::{NoStore, SaveEnd, Storage};
