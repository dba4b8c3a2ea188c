//! Producer of emergencies, its history, and the consumers of others, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::active::ActiveErrors;
pub use super::config::Config;
pub use super::consumers::EmcyConsumers;
pub use super::history::History;
pub use super::producer::Producer;
pub use super::reader::{ErrorReader, ReadOutcome};
