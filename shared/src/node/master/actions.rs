//! Actions of the redundancy, translated into the services of the node.

use super::{Master, MasterEvent, MasterServices, Turn, objects};
use crate::emcy::ErrorCode;
use crate::link::machine::Outgoing;
use crate::link::port::{ErrorState, Health};
use crate::nmt::NmtMessage;
use crate::node::services::{LiveServices, RedundancyServices};
use crate::node::{BusCommand, FailCause, LinkEvent, SpacecraftDevice};
use crate::redundancy::{MasterAction, MasterBoards, Sending};
use crate::types::{Bus, Duration, Frame, NodeId};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    pub(super) fn send_nmt(&mut self, message: NmtMessage, turn: &mut Turn) -> bool {
        self.send(message.encode(), self.services.heartbeat_lifetime(), turn)
    }

    /// Sends a frame on the active bus, when it is announced. Returns false when there was no room to wait for that.
    pub(super) fn send(&mut self, frame: Frame, lifetime: Duration, turn: &mut Turn) -> bool {
        let outgoing = Outgoing { frame, expires: turn.now + lifetime };
        match self.redundancy_mut().send(outgoing) {
            Sending::Now(bus) => turn.out.command(bus, BusCommand::Send(outgoing)),
            Sending::Held => {}
            Sending::Refused(bus) => {
                self.services.buses_mut().count_refused(bus);
                return false;
            }
        }
        true
    }

    /// Reports the state of a controller to the redundancy.
    pub(super) fn report_health(&mut self, bus: Bus, turn: &Turn) {
        let buses = self.services.buses();
        let (health, is_failed) = (buses.health()[bus], buses.is_failed(bus));
        self.redundancy_mut().on_health(bus, health, is_failed, turn.now);
    }

    pub(super) fn on_health(&mut self, bus: Bus, health: Health, turn: &mut Turn) {
        self.report_health(bus, turn);
        self.services.on_health(bus, &health);
        self.services.refresh_health();
        if health.state == ErrorState::BusOff && bus == self.redundancy.active() {
            self.errors_mut().restart();
        }
        turn.out.event(MasterEvent::Health { bus, health });
    }

    pub(super) fn act_if(&mut self, action: Option<MasterAction>, turn: &mut Turn) {
        if let Some(action) = action {
            self.act(action, turn);
        }
    }

    pub(super) fn act(&mut self, action: MasterAction, turn: &mut Turn) {
        match action {
            MasterAction::Heartbeat { bus, frame, expires } => {
                turn.out.send_until(bus, frame, expires);
                self.end_clashes(turn.now, turn);
                self.scrub(turn);
            }
            MasterAction::Send { bus, outgoing } => turn.out.command(bus, BusCommand::Send(outgoing)),
            MasterAction::SendTime => self.services.trigger_time(turn.now),
            MasterAction::Expired { bus, frame } => self.fail(bus, frame, FailCause::Expired, turn),
            MasterAction::Left { bus, frame } => self.fail(bus, frame, FailCause::BusLeft, turn),
            MasterAction::Refused(bus) => self.services.buses_mut().count_refused(bus),
            MasterAction::Switched { from, to, cause } => {
                self.switch(from, to, turn);
                turn.out.event(MasterEvent::BusSwitched { from, to, cause });
                self.on_bus_changed(turn);
            }
            MasterAction::Lost(node) => self.lose(node, turn),
            MasterAction::Forgotten(node) => {
                self.show_state(node, objects::UNKNOWN);
                self.services.errors_mut().forget(node);
            }
            MasterAction::Unheard(node) => {
                self.show_state(node, objects::MISSING);
                turn.out.event(MasterEvent::SlaveUnheard { node });
            }
            MasterAction::GaveUp(bus) => turn.out.event(MasterEvent::GaveUp { bus }),
            MasterAction::RivalHeard(bus) => {
                let info = [bus.bdefault(), 0, 0, 0, 0];
                self.services.raise(ErrorCode::CAN_ID_COLLISION, info);
                turn.out.event(MasterEvent::SecondMaster { bus });
            }
            MasterAction::RivalSilent(bus) => {
                // Slaves may have reported to the other one.
                self.errors_mut().restart();
                self.services.clear(ErrorCode::CAN_ID_COLLISION, bus.bdefault());
                turn.out.event(MasterEvent::SecondMasterSilent { bus });
            }
            MasterAction::TookOver { bus, change } => {
                self.take_over(bus, turn);
                self.on_role(change, turn);
            }
            MasterAction::StoodBy { change, .. } => {
                self.stand_by(turn);
                self.on_role(change, turn);
            }
            MasterAction::HeardMaster(change) => self.on_role(change, turn),
        }
    }

    /// A slave is lost.
    fn lose(&mut self, node: NodeId, turn: &mut Turn) {
        self.show_state(node, objects::MISSING);
        self.boot_mut().on_lost(node);
        self.errors_mut().lose(node);
        turn.out.event(MasterEvent::SlaveLost { node });
    }

    /// Leaves a bus for the other one.
    fn switch(&mut self, from: Bus, to: Bus, turn: &mut Turn) {
        self.services.buses_mut().change(from, to, turn.out);
        self.services.emcy_mut().recall(turn.now);
        self.services.announce(turn.now);
        // With selective access the health of the bus that was left is unknown now, and that of the new one still.
        self.report_health(from, turn);
        self.report_health(to, turn);
        self.services.show_redundancy(self.redundancy.parameters(), turn.now);
    }

    /// A frame waited for the announcement of a bus in vain.
    fn fail(&mut self, bus: Bus, frame: Frame, cause: FailCause, turn: &mut Turn) {
        self.services.buses_mut().count(bus, &LinkEvent::Failed { frame, cause });
        self.on_failed(bus, &frame, cause, turn);
    }
}
