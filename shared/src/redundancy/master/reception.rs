//! Meaning of a received frame for the redundancy of a master.

use super::{MasterAction, MasterBoards, MasterRedundancy};
use crate::heartbeat;
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};

/// Meaning of a received frame. What the machine did not handle, the node passes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MasterVerdict {
    /// Heartbeat or boot-up message of another master, which was handled. Carry out the action.
    OtherMaster(Option<MasterAction>),
    /// Claim of another master, which was handled. Carry out the action.
    Claim(Option<MasterAction>),
    /// Heartbeat or boot-up message of a node, for [`MasterRedundancy::on_heartbeat`], or
    /// [`MasterRedundancy::on_overheard`] if this board is not active.
    Heartbeat {
        /// Node that sent the message.
        node: NodeId,
        /// NMT state of the node.
        state: NmtState,
    },
    /// Message of the SDO server of this node on the active bus, for [`MasterRedundancy::on_answer`] if it answers
    /// this master, or the active one.
    Response(NodeId),
    /// An error in the protocol: heartbeat of a wrong length, or of an unknown state.
    Malformed,
    /// The redundancy has no use for the frame.
    Other,
}

impl<B: MasterBoards, const N: usize, const H: usize> MasterRedundancy<B, N, H> {
    /// Takes a frame of another node that ended at `at`, on a bus that is joined. An active board calls
    /// [`MasterRedundancy::on_frame`] before.
    pub fn on_received(&mut self, bus: Bus, frame: &Frame, at: Instant, now: Instant) -> MasterVerdict {
        let id = frame.id();
        if id == CobId::heartbeat(NodeId::MASTER) {
            return MasterVerdict::OtherMaster(self.on_master(bus, at, now));
        }
        if let Some(claim) = self.standby().and_then(|standby| standby.pair().claim(frame)) {
            return MasterVerdict::Claim(self.on_claim(bus, &claim, at, now));
        }
        let Some(node) = id.node().filter(|node| *node != NodeId::MASTER) else {
            return MasterVerdict::Other;
        };
        if id == CobId::heartbeat(node) {
            let state = heartbeat::decode(frame);
            state.map_or(MasterVerdict::Malformed, |state| MasterVerdict::Heartbeat { node, state })
        } else if id == CobId::sdo_response(node) && bus == self.active() {
            MasterVerdict::Response(node)
        } else {
            MasterVerdict::Other
        }
    }
}
