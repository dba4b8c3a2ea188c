//! Node-ID: 1 is the master, 2..127 are slaves.

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

    /// Makes a Node-ID that is known at compile time. A number out of range does not compile:
    ///
    /// ```compile_fail,E0277
    /// # use async_canopen::types::NodeId;
    /// let node = NodeId::of::<128>();
    /// ```
    pub const fn of<const RAW: u8>() -> NodeId
    where
        RawNodeId<RAW>: IsNodeId<RAW>,
    {
        NodeId(RAW)
    }

    /// Returns the number, `1..=127`.
    pub const fn get(self) -> u8 {
        self.0
    }
}

/// Number as a type, for [`NodeId::of`].
pub struct RawNodeId<const RAW: u8>;

/// Numbers that are Node-IDs, `1..=127`. A bound, so that the compiler reports a wrong number where it is written.
#[diagnostic::on_unimplemented(
    message = "there is no Node-ID {RAW}: a Node-ID is 1 to 127",
    label = "this Node-ID does not exist"
)]
pub trait IsNodeId<const RAW: u8> {}

/// Implements [`IsNodeId`] for numbers.
macro_rules! node_ids {
    ($($number:literal)*) => {
        $(
            #[diagnostic::do_not_recommend]
            impl IsNodeId<$number> for RawNodeId<$number> {}
        )*
    };
}

node_ids! {
    1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20
    21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39 40
    41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60
    61 62 63 64 65 66 67 68 69 70 71 72 73 74 75 76 77 78 79 80
    81 82 83 84 85 86 87 88 89 90 91 92 93 94 95 96 97 98 99 100
    101 102 103 104 105 106 107 108 109 110 111 112 113 114 115 116 117 118 119 120
    121 122 123 124 125 126 127
}
