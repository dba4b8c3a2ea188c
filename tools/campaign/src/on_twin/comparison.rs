//! Replays what a run recorded.

use can_wire::time::Time;
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;
use replay::{Comparison, Recording};

use crate::script::Script;

/// Replays the machines of redundancy of a script's nodes, and compares them with the record.
pub fn compare(script: &Script, recording: &Recording) -> Comparison {
    replay::compare(recording, profile(script), &monitored(), Time::from_us(script.length))
}

/// The profile of the images.
pub fn profile(script: &Script) -> &'static Profile {
    if script.masters == 1 { &mission::STANDARD } else { &mission::TWO_MASTERS }
}

/// Slaves that 1016h of the mission's master names.
pub fn monitored() -> Vec<NodeId> {
    (1..=127).filter_map(NodeId::new).filter(|node| mission::slot(*node).is_some()).collect()
}
