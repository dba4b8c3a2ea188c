//! Carries out the decisions of the redundancy of a slave.

use async_canopen::node::extend::SdoStep;

use super::Slave;
use crate::heartbeat::machine::NodeControl;
use crate::link::Stamp;
use crate::nmt::machine::Reaction;
use crate::node::services::SpacecraftServices;
use crate::node::slave::Turn;
use crate::node::{SlaveEvent, SpacecraftDevice};
use crate::redundancy::machine::SlaveActions;
use crate::redundancy::{BusCause, SlaveAction, SlaveRedundancy, SlaveStep, SlaveVerdict};
use crate::types::{Bus, CobId, Frame};

impl<D: SpacecraftDevice> Slave<D> {
    /// Lets the redundancy decide, and carries out what it decided.
    pub(super) fn decide<R>(
        &mut self,
        turn: &mut Turn,
        decide: impl FnOnce(&mut SlaveRedundancy, &mut SlaveStep) -> R,
    ) -> R {
        let result = self.decide_in_run(turn, decide);
        self.redundancy.settle(self.canopen.wakes_mut());
        result
    }

    /// As [`Slave::decide`], within a run of the node, which looks at all deadlines at its end.
    pub(super) fn decide_in_run<R>(
        &mut self,
        turn: &mut Turn,
        decide: impl FnOnce(&mut SlaveRedundancy, &mut SlaveStep) -> R,
    ) -> R {
        let received = self.canopen.services().buses().received();
        let mut actions = SlaveActions::new();
        let mut step = SlaveStep::new(turn.now, self.canopen.control(), received, &mut actions);
        let result = decide(self.redundancy.no_sooner(), &mut step);
        self.carry_out_all(&actions, turn);
        result
    }

    #[inline(never)] // row `size.pyboard-v11.slave.flash`: once for all decisions
    fn carry_out_all(&mut self, actions: &[SlaveAction], turn: &mut Turn) {
        actions.iter().for_each(|action| self.carry_out(*action, turn));
    }

    /// Restores the communication profile, boots up and begins the search (ECSS 8.3.2).
    pub(super) fn boot(&mut self, turn: &mut Turn) {
        self.canopen.restore_communication(self.initial.heartbeats(), turn.now);
        let parameters = self.canopen.services().written_redundancy();
        let bus = self.redundancy.change(self.canopen.wakes_mut()).boot(parameters, turn.now);
        self.canopen.boot(bus, turn);
    }

    /// Takes a frame other than SYNC, SDO and PDOs of the active bus.
    #[inline(never)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    pub(super) fn on_network(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if frame.id() == CobId::NMT {
            self.canopen.check_node_id();
        }
        let verdict =
            self.redundancy.no_sooner().on_usual_frame(bus, frame, stamp.at, self.canopen.control());
        match verdict.unwrap_or_else(|| self.on_rare_frame(bus, frame, stamp, turn)) {
            SlaveVerdict::Heard => {
                self.canopen.buses_mut().count_heartbeat(bus, frame);
                if frame.bits() == 0 {
                    // A boot-up message: another master, or the same one that has forgotten all.
                    self.canopen.services_mut().announce(turn.now);
                } else {
                    self.canopen.services_mut().confirm_emergencies();
                }
                turn.out.event(SlaveEvent::Heartbeat { bus });
            }
            SlaveVerdict::Taken => self.canopen.buses_mut().count_heartbeat(bus, frame),
            SlaveVerdict::Peer => self.canopen.on_peer_heartbeat(bus, frame, stamp, turn),
            SlaveVerdict::Ignored => self.canopen.buses_mut().count_ignored(bus),
            SlaveVerdict::Malformed => self.canopen.buses_mut().count_malformed(bus),
        }
        self.run(turn);
    }

    #[inline(never)] // row `instructions.heartbeat_consumed`: 5 more without it
    fn on_rare_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) -> SlaveVerdict {
        self.decide(turn, |redundancy, step| redundancy.on_rare_frame(bus, frame, stamp.at, step))
    }

    fn carry_out(&mut self, action: SlaveAction, turn: &mut Turn) {
        let (now, canopen) = (turn.now, &mut self.canopen);
        let event = match action {
            SlaveAction::Obey(command) => {
                return self.change_state(turn, |control| control.on_command(command, now));
            }
            SlaveAction::EnterPreOperational => {
                return self.change_state(turn, NodeControl::on_master_missed);
            }
            SlaveAction::FallSilent { bus } => {
                canopen.services_mut().emcy_mut().hasten();
                canopen.run_device(bus, turn);
                return self.change_state(turn, NodeControl::fall_silent);
            }
            SlaveAction::WaitForReset => return canopen.wait_for_reset(turn),
            SlaveAction::Announce => return canopen.control_mut().announce(now),
            SlaveAction::ShowParameters => {
                return canopen.services_mut().show_redundancy(self.redundancy.parameters(), now);
            }
            SlaveAction::Raise { code, source } => {
                canopen.services_mut().raise(code, [source, 0, 0, 0, 0]);
                return;
            }
            SlaveAction::Clear { code, source } => {
                canopen.services_mut().clear(code, source);
                return;
            }
            SlaveAction::Retain(retained) => return self.memory.write(retained),
            SlaveAction::NoteBdefault { bus, may_write } => return self.note_bdefault(bus, may_write, turn),
            SlaveAction::ActiveBus { bus, cause, is_new } => {
                self.use_bus(bus, cause, is_new, turn);
                SlaveEvent::ActiveBus { bus, cause }
            }
            SlaveAction::MasterMissed { bus } => SlaveEvent::MasterMissed { bus },
            SlaveAction::GaveUp { bus } => SlaveEvent::GaveUp { bus },
            SlaveAction::Clash { bus, yields } => SlaveEvent::Clash { bus, yields },
            SlaveAction::ClashOver => SlaveEvent::ClashOver,
            SlaveAction::ResetIgnored { bus, command } => SlaveEvent::ResetIgnored { bus, command },
        };
        turn.out.event(event);
    }

    /// Follows the choice of a bus.
    fn use_bus(&mut self, bus: Bus, cause: BusCause, is_new: bool, turn: &mut Turn) {
        let canopen = &mut self.canopen;
        if is_new {
            canopen.services_mut().emcy_mut().recall(turn.now);
            canopen.buses_mut().change(bus.other(), bus, turn.out);
            // Aborts the running transfer and reports it on the new bus.
            canopen.serve(SdoStep::BusChanged, bus, turn);
        }
        if matches!(cause, BusCause::Found | BusCause::Followed | BusCause::TakenBack) {
            canopen.services_mut().announce(turn.now);
        }
    }

    fn change_state(&mut self, turn: &mut Turn, change: impl FnOnce(&mut NodeControl) -> Reaction) {
        if self.canopen.change_state(turn, change) {
            self.boot(turn);
        }
    }

    /// Writes Bdefault beyond power-off. A node without a parameter store keeps nothing.
    fn note_bdefault(&mut self, bus: Bus, may_write: bool, turn: &mut Turn) {
        let id = self.canopen.control().id();
        let storage = self.canopen.services_mut().storage_mut();
        let is_kept = if may_write {
            storage.note_bdefault(id, bus).map(|outcome| outcome.is_ok())
        } else {
            Some(false)
        };
        if let Some(is_kept) = is_kept {
            self.memory.write(self.redundancy.no_sooner().on_noted(bus, is_kept));
            turn.out.event(SlaveEvent::BdefaultNoted { bus, is_kept });
        }
    }
}
