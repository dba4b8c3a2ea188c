//! Module control and heartbeats of a slave, and their effect on NMT state and bus.

use super::{Out, Slave};
use crate::emcy::ErrorCode;
use crate::heartbeat;
use crate::link::Stamp;
use crate::nmt::{Command, NmtMessage, Reaction};
use crate::node::services::SdoStep;
use crate::node::{BusCause, Device, SlaveEvent};
use crate::redundancy::{MasterMessage, Selection};
use crate::types::{Bus, Frame, Instant, NodeId, PerBus};

impl<D: Device> Slave<D> {
    pub(super) fn on_nmt(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let Some(message) = NmtMessage::decode(frame) else {
            return self.canopen.services.buses.malformed(bus);
        };
        self.canopen.check_node_id();
        // Not of the master, as far as this node can know: it does not end a search either.
        if self.is_refused(bus, &message, now, out) {
            return;
        }
        // ECSS 8.3.3g before the command itself: it decides where the answer goes.
        self.on_master(bus, MasterMessage::Command, stamp.at, now, out);
        if bus != self.selector.selected() {
            return self.canopen.services.buses.ignored(bus);
        }
        if !message.target.includes(self.canopen.id) {
            return;
        }
        if (self.clashes.has_yielded() || self.budget.is_silent())
            && matches!(message.command, Command::Start | Command::EnterPreOperational)
        {
            return self.canopen.services.buses.ignored(bus);
        }
        match self.canopen.on_command(message.command, now, out) {
            Reaction::Unchanged | Reaction::Entered(_) => {}
            Reaction::ResetNode => {
                self.count_reset();
                self.canopen.wait_for_reset(out);
            }
            Reaction::ResetCommunication => {
                self.count_reset();
                self.boot(now, out);
            }
        }
    }

    pub(super) fn on_master_heartbeat(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        if heartbeat::decode(frame).is_none() {
            return self.canopen.services.buses.malformed(bus);
        }
        if self.guard.is_counting() {
            self.trust_resets();
        }
        if !self.selector.on_beat(bus, stamp.at) {
            self.on_master(bus, MasterMessage::Heartbeat, stamp.at, now, out);
        }
        if bus == self.selector.selected() {
            out.event(SlaveEvent::Heartbeat { bus });
        } else {
            self.canopen.services.buses.ignored(bus);
        }
    }

    #[inline(never)] // the heartbeats of a bus that is followed need not pay for it
    fn on_master(&mut self, bus: Bus, message: MasterMessage, at: Instant, now: Instant, out: &mut Out) {
        let (all, control) = (&self.canopen.services.buses.counters, &self.control_frames);
        self.selector.on_work(PerBus::from_fn(|bus| all[bus].received.wrapping_sub(control[bus])));
        if let Some(selection) = self.selector.on_master(bus, message, at) {
            self.apply(selection, now, out);
        }
        self.canopen.services.wake(self.selector.deadline());
    }

    pub(super) fn apply(&mut self, selection: Selection, now: Instant, out: &mut Out) {
        self.canopen.services.next = now;
        match selection {
            Selection::Missed { bus } => {
                out.event(SlaveEvent::MasterMissed { bus });
                // ECSS 8.3.3e, note 2.
                self.canopen.services.raise(ErrorCode::HEARTBEAT, [NodeId::MASTER.get(), 0, 0, 0, 0]);
                self.warning = Some(now + self.warning_time);
                self.enter_pre_operational(now, out);
            }
            Selection::Toggled { to } => {
                self.enter_pre_operational(now, out);
                self.move_to(to, BusCause::Toggled, now, out);
            }
            Selection::GaveUp { bus } => out.event(SlaveEvent::GaveUp { bus }),
            Selection::Found { bus, moved } => {
                self.confirm();
                self.go_to(bus, moved, BusCause::Found, now, out);
            }
            Selection::Confirmed => self.confirm(),
            Selection::Unconfirmed { bus, moved } => {
                self.enter_pre_operational(now, out);
                self.go_to(bus, moved, BusCause::Unconfirmed, now, out);
            }
            Selection::Followed { to } => {
                self.move_to(to, BusCause::Followed, now, out);
                self.retain_bdefault();
            }
            Selection::Contradicted { bus, moved } => {
                self.canopen.services.raise(ErrorCode::CAN_ID_COLLISION, [NodeId::MASTER.get(), 0, 0, 0, 0]);
                if moved {
                    self.move_to(bus, BusCause::TakenBack, now, out);
                    self.retain_bdefault();
                }
            }
            Selection::Undisputed => {
                self.canopen.services.clear(ErrorCode::CAN_ID_COLLISION, NodeId::MASTER.get())
            }
            Selection::KeepBdefault { bus } => self.keep_bdefault(bus, out),
        }
        self.canopen.services.show_redundancy(self.selector.parameters(), now);
    }

    /// The master is there, as its heartbeat says; a command alone may come from any node.
    fn confirm(&mut self) {
        self.warning = None;
        if self.selector.is_confirmed() {
            self.retain_bdefault();
            self.canopen.services.clear(ErrorCode::HEARTBEAT, NodeId::MASTER.get());
        }
    }

    /// The application of a slave with selective access chose a bus (ECSS 8.2.3a).
    pub(super) fn change_bus(&mut self, bus: Bus, now: Instant, out: &mut Out) {
        let moved = self.selector.select(bus, now);
        self.enter_pre_operational(now, out);
        self.go_to(bus, moved, BusCause::Selected, now, out);
        self.canopen.services.show_redundancy(self.selector.parameters(), now);
    }

    fn go_to(&mut self, bus: Bus, moved: bool, cause: BusCause, now: Instant, out: &mut Out) {
        if moved {
            self.move_to(bus, cause, now, out);
        } else {
            out.event(SlaveEvent::ActiveBus { bus, cause });
        }
    }

    /// Object 2000h; what the node changes itself of it is an event for the TPDOs that carry it.
    pub(super) fn enter_pre_operational(&mut self, now: Instant, out: &mut Out) {
        if self.clashes.has_yielded() {
            return;
        }
        if let Reaction::Entered(state) = self.canopen.nmt.on_master_missed() {
            self.canopen.entered(state, now, out);
        }
    }

    /// The heartbeat goes on on the new bus at once (ECSS 8.3.3d, h).
    fn move_to(&mut self, bus: Bus, cause: BusCause, now: Instant, out: &mut Out) {
        self.canopen.services.buses.change(bus.other(), bus, out);
        // Aborts the running transfer and reports it on the new bus.
        self.canopen.serve(SdoStep::BusChanged, bus, now, out);
        if !self.clashes.has_yielded() {
            self.canopen.heartbeat.announce(now);
        }
        self.canopen.services.next = now;
        out.event(SlaveEvent::ActiveBus { bus, cause });
    }
}
