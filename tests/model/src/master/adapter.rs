//! Passes frames to the redundancy of a master, and carries out its decisions on the wires of the model.

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::link::queue;
use ecss_can::redundancy::{MasterAction, MasterVerdict, Sending};
use ecss_can::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, PerBus};

use super::Master;
use crate::profile::LIFETIME;
use crate::station::Station;

/// Controllers of a lone transmitter.
const ALONE: Health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

impl Master {
    /// A frame of another node.
    pub(super) fn take(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        if frame.id() == CobId::SYNC {
            let action = self.redundancy.on_sync_or_time(bus, now, now);
            return self.act_if(action, now);
        }
        match self.redundancy.on_received(bus, frame, now, now) {
            MasterVerdict::OtherMaster(action) | MasterVerdict::Claim(action) => self.act_if(action, now),
            MasterVerdict::Heartbeat { node, state } => self.on_heartbeat(bus, node, state, now),
            MasterVerdict::Response(node) => self.redundancy.on_answer(node, now),
            MasterVerdict::Malformed | MasterVerdict::Other => {}
        }
    }

    fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, now: Instant) {
        if !self.is_active() {
            self.redundancy.on_overheard(bus, node, state, now);
            return;
        }
        let news = self.redundancy.on_heartbeat(bus, node, state, now, |_| true);
        let Some(message) = news.command else { return };
        let (frame, expires) = (message.encode(), now + LIFETIME);
        match self.redundancy.send(queue::Outgoing { frame, expires }) {
            Sending::Now(bus) => self.outgoing.send_until(bus, frame, expires),
            Sending::Held => {}
            Sending::Refused(bus) => self.act(MasterAction::Refused(bus), now),
        }
    }

    fn act_if(&mut self, action: Option<MasterAction>, now: Instant) {
        if let Some(action) = action {
            self.act(action, now);
        }
    }

    pub(super) fn act(&mut self, action: MasterAction, now: Instant) {
        match action {
            MasterAction::Heartbeat { bus, frame, expires } => self.outgoing.send_until(bus, frame, expires),
            MasterAction::Send { bus, outgoing } => {
                self.outgoing.send_until(bus, outgoing.frame, outgoing.expires)
            }
            MasterAction::Switched { from, cause, .. } => {
                self.switched = Some(cause);
                self.outgoing.abandon(from);
                Bus::ALL.into_iter().for_each(|bus| self.report_health(bus, now));
            }
            MasterAction::TookOver { change, .. } => {
                self.boot_up(now);
                self.role_changed = Some(change);
            }
            MasterAction::StoodBy { change, .. } => {
                self.outgoing.clear();
                self.unacknowledged = PerBus::default();
                self.role_changed = Some(change);
            }
            MasterAction::HeardMaster(change) => self.role_changed = Some(change),
            MasterAction::Refused(bus) => panic!("more frames wait for {bus:?} than the model has places"),
            _ => {}
        }
    }

    pub(super) fn report_health(&mut self, bus: Bus, now: Instant) {
        let health = if self.unacknowledged[bus] { ALONE } else { Health::default() };
        self.redundancy.on_health(bus, health, false, now);
    }

    pub(super) fn boot_up(&mut self, now: Instant) {
        let (queue::Outgoing { frame, expires }, _) = self.redundancy.boot_up(now);
        self.outgoing.send_until(self.active(), frame, expires);
        self.sync.restart(now);
    }
}
