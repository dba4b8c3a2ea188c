//! Frames that a master took from its controllers: which of them is which input of its redundancy.

use ecss_can::emcy::ErrorCode;
use ecss_can::link::budget::is_sdo;
use ecss_can::redundancy::{MasterAction, MasterVerdict, Parameters, PeerHeartbeat, SlaveNews};
use ecss_can::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};

use super::Master;

impl Master {
    /// Takes a frame while this board is active.
    pub(super) fn on_frame(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let id = frame.id();
        let producer = id.node().filter(|node| *node != NodeId::MASTER);
        self.redundancy.on_frame(bus, producer, now);
        if let Some(node) = producer.filter(|_| !is_sdo(id)) {
            self.watch(bus, node, now);
        }
        if id == CobId::sdo_request(NodeId::MASTER) && bus == self.redundancy.active() {
            return;
        }
        match self.redundancy.on_received(bus, frame, now, now) {
            MasterVerdict::OtherMaster(action) | MasterVerdict::Claim(action) => self.act_if(action, now),
            MasterVerdict::Heartbeat { node, state } => self.on_heartbeat(bus, node, state, now),
            MasterVerdict::Response(node) => self.on_sdo_response(node, frame, now),
            MasterVerdict::Malformed | MasterVerdict::Other => {}
        }
    }

    /// Takes a frame while another board is active.
    pub(super) fn overhear(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let id = frame.id();
        if id == CobId::SYNC || id == CobId::local_time(NodeId::MASTER) {
            let action = self.redundancy.on_sync_or_time(bus, now, now);
            self.act_if(action, now);
            if bus == self.redundancy.active() && id == CobId::SYNC {
                self.boot.on_sync_overheard();
            }
            return;
        }
        match self.redundancy.on_received(bus, frame, now, now) {
            MasterVerdict::OtherMaster(action) | MasterVerdict::Claim(action) => self.act_if(action, now),
            MasterVerdict::Heartbeat { node, state } => {
                let heard = self.redundancy.on_overheard(bus, node, state, now);
                self.boot.on_overheard(node, state);
                if heard.changed {
                    self.log(now, format!("slave {}: {state:?} on {bus:?}", node.get()));
                }
            }
            MasterVerdict::Response(node) => self.redundancy.on_answer(node, now),
            MasterVerdict::Malformed | MasterVerdict::Other => {}
        }
    }

    fn act_if(&mut self, action: Option<MasterAction>, now: Instant) {
        if let Some(action) = action {
            self.act(action, now);
        }
    }

    fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, now: Instant) {
        let is_here = bus == self.redundancy.active();
        let is_judged = is_here || state != NmtState::Operational;
        let state = if is_judged { self.judge(node, state, now) } else { state };
        let Self { redundancy, boot, .. } = self;
        let may_start = |heard: PeerHeartbeat| boot.on_heartbeat(node, state, is_here, heard.returned);
        let SlaveNews { heard, command } = redundancy.on_heartbeat(bus, node, state, now, may_start);
        if heard.returned {
            self.log(now, format!("slave {}: back on {bus:?}", node.get()));
        }
        if heard.changed || heard.returned {
            self.log(now, format!("slave {}: {state:?} on {bus:?}", node.get()));
        }
        if let Some(message) = command {
            self.command(message, now);
        }
    }

    /// Returns the state that the master acts on, where two nodes may share a Node-ID.
    fn judge(&mut self, node: NodeId, state: NmtState, now: Instant) -> NmtState {
        let Parameters { producer, consumer, .. } = *self.redundancy.parameters();
        let operational = self.redundancy.peers().operational_at(node);
        let judged = self.clashes.on_heartbeat(node, state, now, operational, [producer, consumer]);
        if judged.is_new {
            self.raise(now, (ErrorCode::CAN_ID_COLLISION.get(), node.get()));
            self.log(now, format!("two nodes have Node-ID {}: EMCY 8150h", node.get()));
        }
        judged.state
    }
}
