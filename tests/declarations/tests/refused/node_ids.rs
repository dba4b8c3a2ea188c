//! Node-IDs that do not exist, in a constant and in a function.

use ecss_can::types::NodeId;

const NONE: NodeId = NodeId::of::<0>();

fn main() {
    let node = NodeId::of::<200>();
    assert_eq!(node, NodeId::of::<128>());
}
