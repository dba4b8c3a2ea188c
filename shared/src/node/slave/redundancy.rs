//! Carries out the decisions of the redundancy of a slave.

use super::retained::Memory;
use super::{Canopen, Out, Slave};
use crate::heartbeat::NodeControl;
use crate::link::Stamp;
use crate::node::services::SdoStep;
use crate::node::{Device, SlaveEvent};
use crate::redundancy::{BusCause, Parameters, SlaveAction, SlaveNode, SlaveRedundancy, SlaveVerdict};
use crate::types::{Bus, CobId, Frame, Instant, PerBus};

/// A slave without its redundancy, in one step.
pub(super) struct Surroundings<'a, D: Device> {
    canopen: &'a mut Canopen<D>,
    memory: &'a mut Memory,
    initial: &'a Parameters,
    now: Instant,
    out: &'a mut Out,
}

impl<D: Device> Slave<D> {
    /// Separates the redundancy from the node around it.
    pub(super) fn split<'a>(
        &'a mut self,
        now: Instant,
        out: &'a mut Out,
    ) -> (&'a mut SlaveRedundancy, Surroundings<'a, D>) {
        let Slave { canopen, redundancy, memory, initial, .. } = self;
        (redundancy, Surroundings { canopen, memory, initial, now, out })
    }

    /// A frame that is none of SYNC, SDO and PDOs on the active bus.
    #[inline(never)]
    pub(super) fn on_network(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        if frame.id() == CobId::NMT {
            self.canopen.check_node_id();
        }
        let (redundancy, node) = self.split(now, out);
        match redundancy.on_frame(bus, frame, stamp.at, now, node) {
            SlaveVerdict::Heard => {
                self.canopen.services.buses.taken(bus, frame);
                if frame.bits() == 0 {
                    // A boot-up message: another master, or the same one that has forgotten all.
                    self.canopen.services.announce(now);
                } else {
                    self.canopen.services.dictionary.emcy.confirm();
                }
                out.event(SlaveEvent::Heartbeat { bus });
            }
            SlaveVerdict::Taken => self.canopen.services.buses.taken(bus, frame),
            SlaveVerdict::Peer => self.canopen.on_peer_heartbeat(bus, frame, stamp, out),
            SlaveVerdict::Ignored => self.canopen.services.buses.ignored(bus),
            SlaveVerdict::Malformed => self.canopen.services.buses.malformed(bus),
        }
        self.run(now, now, out);
    }
}

impl<D: Device> SlaveNode for Surroundings<'_, D> {
    fn control(&mut self) -> &mut NodeControl {
        &mut self.canopen.control
    }

    fn received(&self) -> PerBus<u32> {
        let counters = &self.canopen.services.buses.counters;
        PerBus::from_fn(|bus| counters[bus].received)
    }

    fn restore_communication(&mut self) -> Parameters {
        self.canopen.restore_communication(self.initial, self.now);
        self.canopen.services.written_redundancy()
    }

    fn show(&mut self, parameters: &Parameters) {
        self.canopen.services.show_redundancy(parameters, self.now);
    }

    fn note_bdefault(&mut self, bus: Bus) -> Option<bool> {
        let id = self.canopen.control.id();
        self.canopen.services.dictionary.stored.note_bdefault(id, bus).map(|outcome| outcome.is_ok())
    }

    #[inline(never)] // of many callers
    fn act(&mut self, action: SlaveAction) {
        let Surroundings { canopen, now, out, .. } = self;
        let now = *now;
        canopen.services.next = now;
        let event = match action {
            SlaveAction::BootUp { bus } => return canopen.boot(bus, now, out),
            SlaveAction::Entered(state) => return canopen.entered(state, now, out),
            SlaveAction::ResetNode => return canopen.wait_for_reset(out),
            SlaveAction::Raise { code, source } => {
                canopen.services.raise(code, [source, 0, 0, 0, 0]);
                return;
            }
            SlaveAction::Clear { code, source } => return canopen.services.clear(code, source),
            SlaveAction::SendEmergencies { bus } => {
                canopen.services.dictionary.emcy.hasten();
                return canopen.run_device(bus, now, now, out);
            }
            SlaveAction::Retain(retained) => return self.memory.write(retained),
            SlaveAction::ActiveBus { bus, cause, is_new } => {
                if is_new {
                    canopen.services.dictionary.emcy.recall(now);
                    canopen.services.buses.change(bus.other(), bus, out);
                    // Aborts the running transfer and reports it on the new bus.
                    canopen.serve(SdoStep::BusChanged, bus, now, out);
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
        self.out.event(event);
    }
}
