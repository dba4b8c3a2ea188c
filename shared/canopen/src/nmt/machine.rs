//! NMT slave, guards and watches of a node, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::clash::{Clash, ClashTimes, ClashWatch};
pub use super::reset_guard::{ResetGuard, ResetVerdict};
pub use super::slave::{NmtSlave, Reaction};
pub use super::state_clash::{Judged, StateClashes};
