//! Boot process of a master, as a machine without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::action::BootAction;
pub use super::expected::Assignment;
pub use super::network::Boot;
pub use super::process::{BootRequest, CommonPdo, Identified};
