//! Carries out the actions of the redundancy of a master.

use ecss_can::emcy::ErrorCode;
use ecss_can::link::queue::Outgoing;
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::redundancy::{BabblingStep, MasterAction, RoleChange, Sending};
use ecss_can::types::{Bus, Instant, NodeId};

use super::{Heartbeat, Master};
use crate::machine::Produced;

const COLLISION: u16 = ErrorCode::CAN_ID_COLLISION.get();

impl Master {
    pub(super) fn act(&mut self, action: MasterAction, now: Instant) {
        match action {
            MasterAction::Heartbeat { bus, frame, expires } => {
                self.heartbeats.push(Heartbeat { bus, expires, is_requested: false });
                self.produced.push(Produced::frame(now, bus, frame));
                self.end_clashes(now, now);
            }
            MasterAction::Send { bus, outgoing } => {
                self.produced.push(Produced::frame(now, bus, outgoing.frame));
            }
            MasterAction::Switched { from, to, cause, .. } => {
                self.heartbeats.clear();
                self.report_health(from, now);
                self.report_health(to, now);
                self.log(now, format!("active bus: {to:?}, no longer {from:?} ({cause:?})"));
                self.boot.on_bus_changed();
                self.ask_again();
            }
            MasterAction::Lost(node) => {
                self.boot.on_lost(node);
                self.log(now, format!("slave {}: lost", node.get()));
            }
            MasterAction::Unheard(node) => {
                self.log(now, format!("slave {}: never heard on either bus", node.get()));
            }
            MasterAction::GaveUp(bus) => {
                self.log(now, format!("no slave heard in Ntoggle changes: staying on {bus:?}"));
            }
            MasterAction::RivalHeard(bus) => {
                self.raise(now, (COLLISION, bus.bdefault()));
                self.log(now, format!("another master sends 701h on {bus:?}: EMCY 8150h"));
            }
            MasterAction::RivalSilent(bus) => {
                self.errors.remove(&(COLLISION, bus.bdefault()));
                self.log(now, format!("no more 701h of others on {bus:?}"));
            }
            MasterAction::TookOver { bus, change } => {
                self.boot_up(now);
                self.join(now);
                self.log_role(now, change, Some(bus));
            }
            MasterAction::StoodBy { change, .. } => {
                self.heartbeats.clear();
                self.controllers.leave();
                self.ask_again();
                self.boot.lose_role();
                self.end_clashes(Instant::NEVER, now);
                self.errors.retain(|(code, _)| *code != COLLISION);
                let state = self.redundancy.state();
                self.log(now, format!("{state:?}"));
                self.log_role(now, change, None);
            }
            MasterAction::HeardMaster(change) => self.log_role(now, change, None),
            MasterAction::SendTime
            | MasterAction::Expired(_)
            | MasterAction::Refused(_)
            | MasterAction::Forgotten(_) => {}
        }
    }

    fn log_role(&mut self, now: Instant, RoleChange { role, cause }: RoleChange, bus: Option<Bus>) {
        let on = bus.map(|bus| format!(" on {bus:?}")).unwrap_or_default();
        self.log(now, format!("this master board: {role:?}{on} ({cause:?})"));
    }

    pub(super) fn boot_up(&mut self, now: Instant) {
        let (boot_up, state) = self.redundancy.boot_up(now);
        self.produced.push(Produced::frame(now, self.redundancy.active(), boot_up.frame));
        self.log(now, format!("{state:?}"));
        self.boot.start(now);
    }

    /// Sends a command to a slave.
    pub(super) fn command(&mut self, message: NmtMessage, now: Instant) {
        let outgoing = Outgoing { frame: message.encode(), expires: now + self.profile.heartbeat };
        if let Sending::Now(bus) = self.redundancy.send(outgoing) {
            self.produced.push(Produced::frame(now, bus, outgoing.frame));
        }
    }

    pub(super) fn on_heartbeat_failed(&mut self, place: usize) {
        let heartbeat = self.heartbeats.remove(place);
        self.redundancy.on_failed(heartbeat.bus, ecss_can::types::CobId::heartbeat(NodeId::MASTER));
    }

    /// Ends the clashes of slaves that are over at `until`.
    fn end_clashes(&mut self, until: Instant, now: Instant) {
        while let Some(node) = self.clashes.poll(until, self.redundancy.parameters().consumer) {
            self.errors.remove(&(COLLISION, node.get()));
            self.log(now, format!("one node has Node-ID {} again", node.get()));
        }
    }

    /// Counts a frame of a slave. One that sends too many is stopped, then reset, then its bus is left.
    pub(super) fn watch(&mut self, bus: Bus, node: NodeId, now: Instant) {
        if bus != self.redundancy.active() || !self.redundancy.peers().counts(node) {
            return;
        }
        let is_held = self.redundancy.peers().is_held(node);
        let Some(step) = self.babblers.on_frame(node, is_held, now) else { return };
        let target = Target::Node(node);
        match step {
            BabblingStep::Stopped => {
                self.redundancy.peers_mut().hold(target, true);
                self.boot.on_commanded(target);
                self.command(NmtMessage { command: Command::Stop, target }, now);
            }
            BabblingStep::Reset => self.command(NmtMessage { command: Command::ResetNode, target }, now),
            BabblingStep::BusLeft => self.redundancy.request(self.redundancy.active().other()),
            BabblingStep::Quiet => {}
        }
        self.log_babbling(node, step, now);
    }

    pub(super) fn poll_babblers(&mut self, now: Instant) {
        while let Some((node, was_held)) = self.babblers.poll(now) {
            self.redundancy.peers_mut().hold(Target::Node(node), was_held);
            self.log_babbling(node, BabblingStep::Quiet, now);
        }
    }

    fn log_babbling(&mut self, node: NodeId, step: BabblingStep, now: Instant) {
        self.log(now, format!("slave {}: sends too much, {step:?}", node.get()));
    }
}
