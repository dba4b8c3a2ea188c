//! Transmit queue of a bus, and the depth of all queues of a node.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::depth::{Depth, Places};
pub use super::queue::{Full, Outgoing, TxQueue, is_vital};
