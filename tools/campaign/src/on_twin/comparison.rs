//! Replay of what a run recorded.

use can_wire::time::Time;
use ecss_can::types::NodeId;
use replay::{Comparison, Mission, Recording};

use crate::script::Script;

/// Replays the machines of redundancy of a script's nodes, and compares them with the record.
pub fn compare(script: &Script, recording: &Recording) -> Comparison {
    let profile = if script.masters == 1 { &mission::STANDARD } else { &mission::TWO_MASTERS };
    let nodes = (1..=127).filter_map(NodeId::new);
    let monitored: Vec<NodeId> = nodes.filter(|node| mission::slot(*node).is_some()).collect();
    replay::compare(recording, &Mission { profile, monitored: &monitored }, Time::from_us(script.length))
}
