//! Carries out the decisions of the redundancy of a slave.

use super::retained::Memory;
use super::{Canopen, Slave};
use crate::heartbeat::NodeControl;
use crate::link::Stamp;
use crate::node::canopen::Turn;
use crate::node::services::SdoStep;
use crate::node::{Device, SlaveEvent};
use crate::redundancy::{BusCause, Parameters, SlaveAction, SlaveNode, SlaveRedundancy, SlaveVerdict};
use crate::types::{Bus, CobId, Frame, PerBus};

/// A slave without its redundancy, in one step.
pub(super) struct Surroundings<'a, 't, D: Device> {
    canopen: &'a mut Canopen<D>,
    memory: &'a mut Memory,
    initial: &'a Parameters,
    turn: &'a mut Turn<'t>,
}

impl<D: Device> Slave<D> {
    /// Lets the redundancy decide, and the node around it carry out.
    pub(super) fn decide<R>(
        &mut self,
        turn: &mut Turn,
        step: impl FnOnce(&mut SlaveRedundancy, &mut Surroundings<D>) -> R,
    ) -> R {
        let Slave { canopen, redundancy, memory, initial, .. } = self;
        let surroundings = &mut Surroundings { canopen, memory, initial, turn };
        let result = step(redundancy.no_sooner(), surroundings);
        redundancy.settle(&mut canopen.services.wakes);
        result
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
        let now = turn.now;
        self.decide(turn, |redundancy, node| redundancy.on_rare_frame(bus, frame, stamp.at, now, node))
    }
}

impl<D: Device> SlaveNode for Surroundings<'_, '_, D> {
    fn control(&self) -> &NodeControl {
        &self.canopen.control
    }

    fn control_mut(&mut self) -> &mut NodeControl {
        self.canopen.control.change(&mut self.canopen.services.wakes)
    }

    fn received(&self) -> PerBus<u32> {
        let counters = self.canopen.services.counters.all();
        PerBus::from_fn(|bus| counters[bus].received)
    }

    fn restore_communication(&mut self) -> Parameters {
        self.canopen.restore_communication(self.initial, self.turn.now);
        self.canopen.services.written_redundancy()
    }

    fn show(&mut self, parameters: &Parameters) {
        self.canopen.services.show_redundancy(parameters, self.turn.now);
    }

    fn note_bdefault(&mut self, bus: Bus) -> Option<bool> {
        let id = self.canopen.control.id();
        self.canopen.services.dictionary.stored.note_bdefault(id, bus).map(|outcome| outcome.is_ok())
    }

    #[inline(never)] // of many callers
    fn act(&mut self, action: SlaveAction) {
        let Surroundings { canopen, turn, .. } = self;
        let now = turn.now;
        let event = match action {
            SlaveAction::BootUp { bus } => return canopen.boot(bus, turn),
            SlaveAction::Entered(state) => return canopen.entered(state, turn),
            SlaveAction::ResetNode => return canopen.wait_for_reset(turn),
            SlaveAction::Raise { code, source } => {
                canopen.services.raise(code, [source, 0, 0, 0, 0]);
                return;
            }
            SlaveAction::Clear { code, source } => {
                canopen.services.clear(code, source);
                return;
            }
            SlaveAction::SendEmergencies { bus } => {
                canopen.services.dictionary.emcy.change(&mut canopen.services.wakes).hasten();
                return canopen.run_device(bus, turn);
            }
            SlaveAction::Retain(retained) => return self.memory.write(retained),
            SlaveAction::ActiveBus { bus, cause, is_new } => {
                if is_new {
                    canopen.services.dictionary.emcy.change(&mut canopen.services.wakes).recall(now);
                    canopen.services.buses.no_sooner().change(bus.other(), bus, turn.out);
                    // Aborts the running transfer and reports it on the new bus.
                    canopen.serve(SdoStep::BusChanged, bus, turn);
                }
                if matches!(cause, BusCause::Found | BusCause::Followed | BusCause::TakenBack) {
                    canopen.services.announce(now);
                }
                SlaveEvent::ActiveBus { bus, cause }
            }
            SlaveAction::MasterMissed { bus } => SlaveEvent::MasterMissed { bus },
            SlaveAction::GaveUp { bus } => SlaveEvent::GaveUp { bus },
            SlaveAction::Clash { bus, yields } => SlaveEvent::Clash { bus, yields },
            SlaveAction::ClashOver => SlaveEvent::ClashOver,
            SlaveAction::ResetIgnored { bus, command } => SlaveEvent::ResetIgnored { bus, command },
            SlaveAction::BdefaultNoted { bus, is_kept } => SlaveEvent::BdefaultNoted { bus, is_kept },
        };
        turn.out.event(event);
    }
}
