//! Passes frames to the redundancy of a master, and carries out its decisions on the wires of the model.

use ecss_can::link::machine;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::redundancy::machine::{MasterAction, MasterVerdict, Sending};
use ecss_can::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, PerBus};

use super::Master;
use super::errors::Known;
use crate::profile::LIFETIME;
use crate::station::Station;

/// State of controllers of a lone transmitter.
const ALONE: Health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

impl Master {
    /// Handles a frame of another node.
    pub(super) fn take(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        if frame.id() == CobId::SYNC {
            let action = self.redundancy.on_sync_or_time(bus, now, now);
            return action.into_iter().for_each(|action| self.act(action, now));
        }
        match self.redundancy.on_received(bus, frame, now, now) {
            MasterVerdict::OtherMaster(action) | MasterVerdict::Claim(action) => {
                action.into_iter().for_each(|action| self.act(action, now));
            }
            MasterVerdict::Heartbeat { node, state } => self.on_heartbeat(bus, node, state, now),
            MasterVerdict::Response(node) => {
                self.boot.on_answer(node);
                self.redundancy.on_answer(node, now);
                self.take_answer(frame, now);
            }
            MasterVerdict::Malformed => {}
            MasterVerdict::Other => self.follow(bus, frame, now),
        }
    }

    fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, now: Instant) {
        if !self.is_active() {
            self.redundancy.on_overheard(bus, node, state, now);
            return;
        }
        let heard = self.redundancy.on_heartbeat(bus, node, state, now);
        let may_start = self.boot.may_start(node, state, heard.returned);
        if let Some(message) = heard.command(node, state, may_start) {
            self.send(message.encode(), now);
        }
        if bus == self.active() {
            self.is_heard(node, state, heard.changed, now);
        }
        if bus == self.active() && self.boot.asks(node, state) {
            self.send(Frame::of(CobId::sdo_request(node), []), now);
        }
    }

    pub(super) fn send(&mut self, frame: Frame, now: Instant) {
        let expires = now + LIFETIME;
        match self.redundancy.send(machine::Outgoing { frame, expires }) {
            Sending::Now(bus) => self.outgoing.send_until(bus, frame, expires),
            Sending::Held => {}
            Sending::Refused(bus) => self.act(MasterAction::Refused(bus), now),
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
                self.is_announced = false;
                self.outgoing.abandon(from);
                self.known.iter_mut().for_each(Known::restart);
                Bus::ALL.into_iter().for_each(|bus| self.report_health(bus, now));
            }
            MasterAction::TookOver { change, .. } => {
                self.known.iter_mut().for_each(Known::restart);
                self.boot_up(now);
                self.change_role(change, false);
            }
            MasterAction::StoodBy { change, .. } => {
                self.outgoing.clear();
                self.known.iter_mut().for_each(Known::restart);
                self.unacknowledged = PerBus::default();
                self.change_role(change, true);
            }
            MasterAction::HeardMaster(change) => self.change_role(change, false),
            MasterAction::Lost(node) => self.lose(node),
            MasterAction::Refused(bus) => panic!("more frames wait for {bus:?} than the model has places"),
            _ => {}
        }
    }

    pub(super) fn report_health(&mut self, bus: Bus, now: Instant) {
        let health = if self.unacknowledged[bus] { ALONE } else { Health::default() };
        self.redundancy.on_health(bus, health, self.failed[bus], now);
    }
}
