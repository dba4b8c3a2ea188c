//! Node-ID: 1 is the master, 2..127 are slaves (ECSS 6.10).

/// Valid Node-ID, `1..=127`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeId(u8);

impl NodeId {
    /// Node-ID of the NMT and redundancy master.
    pub const MASTER: NodeId = NodeId(1);

    /// Makes a Node-ID. `None` for 0 and above 127.
    pub const fn new(raw: u8) -> Option<NodeId> {
        if raw >= 1 && raw <= 127 { Some(NodeId(raw)) } else { None }
    }

    /// Makes a Node-ID that is known at compile time. A number out of range does not compile.
    pub const fn of<const RAW: u8>() -> NodeId {
        const { assert!(RAW >= 1 && RAW <= 127, "a Node-ID is 1..=127") };
        NodeId(RAW)
    }

    /// Returns the number, `1..=127`.
    pub const fn get(self) -> u8 {
        self.0
    }
}
