//! NMT state and role of the master, and the bus that it uses: carries out the actions of the redundancy.
//!
//! A master board is active or the standby (ECSS 8.1a, Figure 4-2). A standby sends no dominant bit. It follows the active
//! master: the bus of its heartbeat, the states of the slaves, and the spacecraft time. So the time continues when it takes
//! over.

use super::initial::written_redundancy;
use super::objects::{MISSING, UNKNOWN};
use super::{Identification, Master, MasterEvent, MasterServices, Turn};
use crate::emcy::ErrorCode;
use crate::link::port::{ErrorState, Health};
use crate::nmt::machine::Reaction;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::services::{LiveServices, SpacecraftServices, TimeServices};
use crate::node::{BusCommand, FailCause, MasterRole, SpacecraftDevice};
use crate::redundancy::{MasterAction, MasterBoards, Role, RoleChange};
use crate::store::Group;
use crate::types::{Bus, CobId, Instant, NmtState, NodeId};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns whether the board manages the network. `false` while it listens or is the standby.
    pub fn is_active(&self) -> bool {
        self.redundancy.is_active()
    }

    /// Returns the COB-ID of the spacecraft time while it must not be sent.
    ///
    /// That is so if this board took over before it received a time: the slaves have the time of the other board.
    /// It ends when the clock is set by [`MasterRequest::SetTime`](crate::node::MasterRequest::SetTime) or by a
    /// client (2010h, 2012h). Always `None` with one master board.
    pub(crate) fn withheld_time(&self) -> Option<CobId> {
        let is_known = self.redundancy.standby().is_none_or(|standby| standby.has_begun());
        if is_known || self.services.time().clock().is_set() {
            return None;
        }
        self.services.time_pdo().map(|pdo| pdo.id)
    }

    /// Power-on of one of two boards: it listens, silent on both buses.
    pub(super) fn listen(&mut self, turn: &mut Turn) {
        self.services.configure(turn.now);
        self.services.buses_mut().listen(turn.out);
        self.show_role();
    }

    /// Becomes active.
    pub(super) fn take_over(&mut self, bus: Bus, turn: &mut Turn) {
        self.services.show_redundancy(self.redundancy.parameters(), turn.now);
        self.services.buses_mut().join(bus, turn.out);
        self.errors_mut().restart();
        self.boot_up(turn);
        self.boot_mut().start(turn.now);
    }

    /// Becomes the standby of another active master.
    pub(super) fn stand_by(&mut self, turn: &mut Turn) {
        self.services.buses_mut().listen(turn.out);
        self.services.emcy_mut().recall(turn.now);
        self.drop_transfers(turn.now);
        self.boot_mut().stand_by();
        *self.identification.change(self.services.wakes_mut()) = Identification::default();
        self.rescue.no_sooner().stand_by();
        self.end_clashes(Instant::NEVER, turn);
        for bus in Bus::ALL {
            self.services.clear(ErrorCode::CAN_ID_COLLISION, bus.bdefault());
        }
        self.entered(NmtState::Initialising, turn);
    }

    pub(super) fn on_role(&mut self, change: RoleChange, turn: &mut Turn) {
        self.show_role();
        turn.out.event(MasterEvent::Role(change));
    }

    /// Object 2045h.
    fn show_role(&mut self) {
        let Some(standby) = self.redundancy.standby() else { return };
        let (role, strap) = (standby.role() as u8, standby.strap() as u8);
        let shown: &mut MasterRole = &mut self.services.network_mut().role;
        if role == Role::Active as u8 && shown.role != role {
            shown.taken = shown.taken.saturating_add(1);
        }
        (shown.role, shown.strap) = (role, strap);
    }

    /// Sends the boot-up message and enters Operational without a command (CiA 301 7.3.2.2.1).
    pub(super) fn boot_up(&mut self, turn: &mut Turn) {
        let (boot_up, state) = self.redundancy_mut().boot_up(turn.now);
        turn.out.command(self.redundancy.active(), BusCommand::Send(boot_up));
        self.is_booting = true;
        self.services.configure(turn.now);
        let sync = self.sync.change(self.services.wakes_mut());
        sync.configure(self.services.objects().communication.sync.config(), turn.now);
        sync.set_dither(self.services.network().sync_dither);
        sync.start(turn.now);
        self.entered(state, turn);
    }

    pub(super) fn entered(&mut self, state: NmtState, turn: &mut Turn) {
        self.services.entered(state, turn.now);
        if !state.allows_sync() {
            self.sync.no_sooner().restart_counter();
        }
        self.show_state(NodeId::MASTER, state.byte());
        turn.out.event(MasterEvent::State(state));
    }

    /// Commands slaves, or itself: asked by its application, or by a write to 1F82h. A standby sends nothing.
    pub(super) fn on_nmt_request(&mut self, message: NmtMessage, turn: &mut Turn) {
        if !self.is_active() {
            let node = if let Target::Node(node) = message.target { node } else { NodeId::MASTER };
            return turn.out.event(MasterEvent::Refused { node });
        }
        self.on_application_command(message.target, turn);
        if self.redundancy_mut().on_command(message.command, message.target) {
            self.boot_mut().on_commanded(message.target);
        }
        if message.target == Target::Node(NodeId::MASTER) {
            self.on_own_command(message.command, turn);
        } else if !self.send_nmt(message, turn)
            && let Target::Node(node) = message.target
        {
            turn.out.event(MasterEvent::Refused { node });
        }
    }

    /// Obeys a command of the application, or of a client in 1F82h.
    pub(super) fn on_own_command(&mut self, command: Command, turn: &mut Turn) {
        if command == Command::ResetNode {
            // Until the application resets the chip it goes on as it was.
            return turn.out.event(MasterEvent::ResetNode);
        }
        let reaction = self.redundancy_mut().on_own_command(command);
        match reaction {
            Reaction::Unchanged | Reaction::ResetNode => {}
            Reaction::Entered(state) => self.entered(state, turn),
            Reaction::ResetCommunication => {
                self.initial.restore(self.services.objects_mut());
                self.services.load(Group::Communication);
                let redundancy = written_redundancy(&self.services, &self.initial);
                self.take_assignments();
                self.redundancy_mut().configure(redundancy, turn.now);
                self.note_filters();
                self.boot_up(turn);
            }
        }
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
                self.show_state(node, UNKNOWN);
                self.services.errors_mut().forget(node);
            }
            MasterAction::Unheard(node) => {
                self.show_state(node, MISSING);
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

    /// Reports that a slave is lost.
    fn lose(&mut self, node: NodeId, turn: &mut Turn) {
        self.show_state(node, MISSING);
        self.boot_mut().on_lost(node);
        self.errors_mut().lose(node);
        // A minimal slave has no NMT commands (ECSS 9.4.6.1a).
        if self.minimal(node).is_none() {
            self.rescue.no_sooner().on_lost(turn.now);
        }
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
}
