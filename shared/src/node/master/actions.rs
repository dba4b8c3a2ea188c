//! Actions of the redundancy, translated into the services of the node.

use super::{Master, MasterEvent, Out, objects};
use crate::emcy::ErrorCode;
use crate::link::port::{ErrorState, Health};
use crate::link::queue::Outgoing;
use crate::nmt::NmtMessage;
use crate::node::{BusCommand, Device, FailCause, LinkEvent};
use crate::redundancy::{MasterAction, MasterBoards, Sending};
use crate::types::{Bus, Duration, Frame, Instant};

impl<D: Device, B: MasterBoards> Master<D, B> {
    pub(super) fn send_nmt(&mut self, message: NmtMessage, now: Instant, out: &mut Out) -> bool {
        self.send(message.encode(), now, self.services.lifetimes.heartbeat, out)
    }

    /// Sends a frame on the active bus, when it is announced. Returns false when there was no room to wait for that.
    pub(super) fn send(&mut self, frame: Frame, now: Instant, lifetime: Duration, out: &mut Out) -> bool {
        let outgoing = Outgoing { frame, expires: now + lifetime };
        match self.redundancy.send(outgoing) {
            Sending::Now(bus) => out.command(bus, BusCommand::Send(outgoing)),
            Sending::Held => {}
            Sending::Refused(bus) => {
                self.services.buses.refused(bus);
                return false;
            }
        }
        true
    }

    /// Reports the state of a controller to the redundancy.
    pub(super) fn report_health(&mut self, bus: Bus, now: Instant) {
        let buses = &self.services.buses;
        self.redundancy.on_health(bus, buses.health[bus], buses.is_failed(bus), now);
    }

    pub(super) fn on_health(&mut self, bus: Bus, health: Health, now: Instant, out: &mut Out) {
        self.report_health(bus, now);
        self.services.on_health(bus, &health);
        self.services.refresh_health();
        self.services.next = Instant::ZERO;
        if health.state == ErrorState::BusOff && bus == self.redundancy.active() {
            self.errors.restart();
        }
        out.event(MasterEvent::Health { bus, health });
    }

    pub(super) fn act_if(&mut self, action: Option<MasterAction>, now: Instant, out: &mut Out) {
        if let Some(action) = action {
            self.act(action, now, out);
        }
    }

    pub(super) fn act(&mut self, action: MasterAction, now: Instant, out: &mut Out) {
        match action {
            MasterAction::Heartbeat { bus, frame, expires } => {
                out.send_until(bus, frame, expires);
                self.end_clashes(now, out);
                self.scrub(now);
            }
            MasterAction::Send { bus, outgoing } => out.command(bus, BusCommand::Send(outgoing)),
            MasterAction::SendTime => self.services.trigger_time(now),
            MasterAction::Expired { bus, frame } => self.fail(bus, frame, FailCause::Expired, now, out),
            MasterAction::Left { bus, frame } => self.fail(bus, frame, FailCause::BusLeft, now, out),
            MasterAction::Refused(bus) => self.services.buses.refused(bus),
            MasterAction::Switched { from, to, cause } => {
                self.services.buses.change(from, to, out);
                self.services.dictionary.emcy.recall(now);
                self.services.announce(now);
                // With selective access the health of the bus left is unknown now, that of the new one still.
                self.report_health(from, now);
                self.report_health(to, now);
                self.services.show_redundancy(self.redundancy.parameters(), now);
                out.event(MasterEvent::BusSwitched { from, to, cause });
                self.on_bus_changed(now, out);
            }
            MasterAction::Lost(node) => {
                self.show_state(node, objects::MISSING);
                self.boot.on_lost(node);
                self.errors.lose(node);
                out.event(MasterEvent::SlaveLost { node });
            }
            MasterAction::Forgotten(node) => {
                self.show_state(node, objects::UNKNOWN);
                self.services.dictionary.objects.application.errors.forget(node);
            }
            MasterAction::Unheard(node) => {
                self.show_state(node, objects::MISSING);
                out.event(MasterEvent::SlaveUnheard { node });
            }
            MasterAction::GaveUp(bus) => out.event(MasterEvent::GaveUp { bus }),
            MasterAction::RivalHeard(bus) => {
                self.services.raise(ErrorCode::CAN_ID_COLLISION, [bus.bdefault(), 0, 0, 0, 0]);
                self.services.next = Instant::ZERO;
                out.event(MasterEvent::SecondMaster { bus });
            }
            MasterAction::RivalSilent(bus) => {
                // Slaves may have reported to the other one.
                self.errors.restart();
                self.services.clear(ErrorCode::CAN_ID_COLLISION, bus.bdefault());
                self.services.next = Instant::ZERO;
                out.event(MasterEvent::SecondMasterSilent { bus });
            }
            MasterAction::TookOver { bus, change } => {
                self.take_over(bus, now, out);
                self.on_role(change, out);
            }
            MasterAction::StoodBy { change, .. } => {
                self.stand_by(now, out);
                self.on_role(change, out);
            }
            MasterAction::HeardMaster(change) => self.on_role(change, out),
        }
    }

    /// A frame waited for the announcement of a bus in vain.
    fn fail(&mut self, bus: Bus, frame: Frame, cause: FailCause, now: Instant, out: &mut Out) {
        self.services.buses.on_link(bus, &LinkEvent::Failed { frame, cause }, now);
        self.on_failed(bus, &frame, cause, now, out);
    }
}
