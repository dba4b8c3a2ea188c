//! Carries out the decisions of the redundancy of a slave.

use async_canopen::node::extend::SdoStep;

use super::Slave;
use crate::link::Stamp;
use crate::nmt::machine::Reaction;
use crate::node::services::RedundancyServices;
use crate::node::slave::Turn;
use crate::node::{SlaveEvent, SpacecraftDevice};
use crate::redundancy::{BusCause, SlaveAction, SlaveRedundancy, SlaveStep, SlaveVerdict};
use crate::types::{Bus, CobId, Frame};

impl<D: SpacecraftDevice> Slave<D> {
    /// Lets the redundancy decide, and carries out what it decided.
    pub(super) fn decide<R>(
        &mut self,
        turn: &mut Turn,
        decide: impl FnOnce(&mut SlaveRedundancy, &mut SlaveStep) -> R,
    ) -> R {
        let Slave { canopen, redundancy, .. } = self;
        let received = canopen.services.counters.all_received();
        let mut step = SlaveStep::new(turn.now, &canopen.control, received);
        let result = decide(redundancy.no_sooner(), &mut step);
        let actions = step.into_actions();
        self.carry_out_all(&actions, turn);
        result
    }

    #[inline(never)] // row `size.pyboard-v11.slave.flash`: once for all decisions
    fn carry_out_all(&mut self, actions: &[SlaveAction], turn: &mut Turn) {
        self.redundancy.settle(&mut self.canopen.services.wakes);
        actions.iter().for_each(|action| self.carry_out(*action, turn));
    }

    /// Restores the communication profile, boots up and begins the search (ECSS 8.3.2).
    pub(super) fn boot(&mut self, turn: &mut Turn) {
        self.canopen.restore_communication(self.initial.heartbeats(), turn.now);
        let services = &mut self.canopen.services;
        let parameters = services.written_redundancy();
        let bus = self.redundancy.change(&mut services.wakes).boot(parameters, turn.now);
        self.canopen.boot(bus, turn);
    }

    /// A frame that is none of SYNC, SDO and PDOs on the active bus.
    #[inline(never)]
    pub(super) fn on_network(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if frame.id() == CobId::NMT {
            self.canopen.check_node_id();
        }
        let verdict = self.redundancy.no_sooner().on_usual_frame(bus, frame, stamp.at, &self.canopen.control);
        match verdict.unwrap_or_else(|| self.on_rare_frame(bus, frame, stamp, turn)) {
            SlaveVerdict::Heard => {
                self.canopen.services.counters.taken(bus, frame);
                if frame.bits() == 0 {
                    // A boot-up message: another master, or the same one that has forgotten all.
                    self.canopen.services.announce(turn.now);
                } else {
                    self.canopen.services.dictionary.emcy.no_sooner().confirm();
                }
                turn.out.event(SlaveEvent::Heartbeat { bus });
            }
            SlaveVerdict::Taken => self.canopen.services.counters.taken(bus, frame),
            SlaveVerdict::Peer => self.canopen.on_peer_heartbeat(bus, frame, stamp, turn),
            SlaveVerdict::Ignored => self.canopen.services.counters.ignored(bus),
            SlaveVerdict::Malformed => self.canopen.services.counters.malformed(bus),
        }
        self.run(turn);
    }

    #[inline(never)] // a heartbeat of the master need not pay for it
    fn on_rare_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) -> SlaveVerdict {
        self.decide(turn, |redundancy, step| redundancy.on_rare_frame(bus, frame, stamp.at, step))
    }

    fn carry_out(&mut self, action: SlaveAction, turn: &mut Turn) {
        let Slave { canopen, redundancy, .. } = self;
        let now = turn.now;
        let wakes = &mut canopen.services.wakes;
        let event = match action {
            SlaveAction::Obey(command) => {
                let reaction = canopen.control.change(wakes).on_command(command, now);
                return self.change_state(reaction, turn);
            }
            SlaveAction::EnterPreOperational => {
                let reaction = canopen.control.change(wakes).on_master_missed();
                return self.change_state(reaction, turn);
            }
            SlaveAction::FallSilent { bus } => {
                canopen.services.dictionary.emcy.change(wakes).hasten();
                canopen.run_device(bus, turn);
                let reaction = canopen.control.change(&mut canopen.services.wakes).fall_silent();
                return self.change_state(reaction, turn);
            }
            SlaveAction::WaitForReset => return canopen.wait_for_reset(turn),
            SlaveAction::Announce => return canopen.control.change(wakes).announce(now),
            SlaveAction::ShowParameters => {
                return canopen.services.show_redundancy(redundancy.parameters(), now);
            }
            SlaveAction::Raise { code, source } => {
                canopen.services.raise(code, [source, 0, 0, 0, 0]);
                return;
            }
            SlaveAction::Clear { code, source } => {
                canopen.services.clear(code, source);
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
            canopen.services.dictionary.emcy.change(&mut canopen.services.wakes).recall(turn.now);
            canopen.services.buses.no_sooner().change(bus.other(), bus, turn.out);
            // Aborts the running transfer and reports it on the new bus.
            canopen.serve(SdoStep::BusChanged, bus, turn);
        }
        if matches!(cause, BusCause::Found | BusCause::Followed | BusCause::TakenBack) {
            canopen.services.announce(turn.now);
        }
    }

    #[inline(never)] // row `size.pyboard-v11.slave.flash`: of three callers
    fn change_state(&mut self, reaction: Reaction, turn: &mut Turn) {
        if self.canopen.follow(reaction, turn) {
            self.boot(turn);
        }
    }

    /// Writes Bdefault beyond power-off. A node without a parameter store keeps nothing.
    fn note_bdefault(&mut self, bus: Bus, may_write: bool, turn: &mut Turn) {
        let id = self.canopen.control.id();
        let mut note = || self.canopen.services.dictionary.stored.note_bdefault(id, bus);
        let outcome = if may_write { note().map(|outcome| outcome.is_ok()) } else { Some(false) };
        if let Some(is_kept) = outcome {
            self.memory.write(self.redundancy.no_sooner().on_noted(bus, is_kept));
            turn.out.event(SlaveEvent::BdefaultNoted { bus, is_kept });
        }
    }
}
