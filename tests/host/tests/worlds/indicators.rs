//! Indicators of the nodes of a world.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use ecss_can::types::NodeId;
use ecss_can_worlds::ResetLine;
use mission::Indicators;

/// Indicators of an application, across its resets.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    pub syncs: u32,
    pub heartbeats: u32,
    pub times: u32,
    /// States of the state LED, one per change.
    pub states: Vec<bool>,
    pub resets: u32,
}

/// Records the indicators of all nodes.
#[derive(Clone, Default)]
pub struct IndicatorLog(Rc<RefCell<BTreeMap<NodeId, Shown>>>);

impl IndicatorLog {
    /// Returns the recorded indicators of a node.
    pub fn shown(&self, node: NodeId) -> Shown {
        self.0.borrow().get(&node).cloned().unwrap_or_default()
    }

    /// Returns indicators for a node, which are recorded.
    pub fn of(&self, node: NodeId, reset: ResetLine) -> NodeIndicators {
        NodeIndicators { indicators: self.clone(), node, reset }
    }
}

/// The indicators of one node.
pub struct NodeIndicators {
    indicators: IndicatorLog,
    node: NodeId,
    reset: ResetLine,
}

impl NodeIndicators {
    fn note(&self, change: impl FnOnce(&mut Shown)) {
        change(self.indicators.0.borrow_mut().entry(self.node).or_default());
    }
}

impl Indicators for NodeIndicators {
    fn sync(&mut self) {
        self.note(|shown| shown.syncs += 1);
    }

    fn heartbeat(&mut self) {
        self.note(|shown| shown.heartbeats += 1);
    }

    fn time(&mut self) {
        self.note(|shown| shown.times += 1);
    }

    fn state(&mut self, on: bool) {
        self.note(|shown| shown.states.push(on));
    }

    fn reset(&mut self) {
        self.note(|shown| shown.resets += 1);
        self.reset.reset();
    }
}
