//! Producer and consumers of heartbeats, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::consumer::{Consumer, ConsumerTimes};
pub use super::entry::{check_entry, longest_time, monitored, time_of};
pub use super::monitor::{Heard, Missed, Monitor};
pub use super::node_control::NodeControl;
pub use super::producer::Producer;
pub use super::staggered::Staggered;
