//! Producer and consumer of SYNC, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::config::Config;
pub use super::consumer::{Consumer, UnexpectedLength};
pub use super::producer::Producer;
