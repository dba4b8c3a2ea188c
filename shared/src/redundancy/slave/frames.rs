//! Frames of network management: module control and heartbeats, and the ends of the node's own frames.

use super::{SlaveAction as Action, SlaveRedundancy, SlaveStep, SlaveVerdict};
use crate::emcy::ErrorCode;
use crate::heartbeat::machine::NodeControl;
use crate::heartbeat::{self, is_heartbeat};
use crate::nmt::{Command, NmtMessage};
use crate::redundancy::MasterMessage;
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, PerBus};

impl SlaveRedundancy {
    /// Takes a frame that ended at `at`, and is none of the node's SYNC, SDO or PDOs on the active bus. Call
    /// [`SlaveRedundancy::poll`] until `at` before. Returns `None` if the frame is one for
    /// [`SlaveRedundancy::on_rare_frame`]. Otherwise nothing is due earlier than before.
    #[inline(always)] // called from one place: rows `instructions.heartbeat_consumed`, `load.cycles_per_frame`
    pub fn on_usual_frame(
        &mut self,
        bus: Bus,
        frame: &Frame,
        at: Instant,
        control: &NodeControl,
    ) -> Option<SlaveVerdict> {
        let id = frame.id();
        let is_heartbeat = is_heartbeat(id);
        let is_control = is_heartbeat || id == CobId::NMT;
        if is_control {
            self.control_frames[bus] = self.control_frames[bus].wrapping_add(1);
        }
        if control.state() != NmtState::Initialising {
            if !is_control {
                return Some(SlaveVerdict::Ignored);
            }
            if is_heartbeat && bus == self.selected() {
                if id == CobId::heartbeat(NodeId::MASTER) {
                    // Nearly each one: no reset counts, and the master is followed on this bus.
                    if !self.guard.is_counting()
                        && heartbeat::decode(frame).is_some()
                        && self.selector.on_beat(bus, at)
                    {
                        return Some(SlaveVerdict::Heard);
                    }
                } else if id != CobId::heartbeat(control.id()) {
                    return Some(SlaveVerdict::Peer);
                }
            }
        }
        None
    }

    /// Takes a frame that [`SlaveRedundancy::on_usual_frame`] did not handle.
    pub fn on_rare_frame(
        &mut self,
        bus: Bus,
        frame: &Frame,
        at: Instant,
        step: &mut SlaveStep,
    ) -> SlaveVerdict {
        let id = frame.id();
        if step.control.state() == NmtState::Initialising {
            // Repeated with every frame: if the action were lost in a full queue, the node would stay silent.
            step.act(Action::WaitForReset);
            SlaveVerdict::Ignored
        } else if !self.is_joined(bus) {
            SlaveVerdict::Ignored
        } else if id == CobId::NMT {
            self.on_nmt(bus, frame, at, step)
        } else if id == CobId::heartbeat(NodeId::MASTER) {
            self.on_master_heartbeat(bus, frame, at, step)
        } else if id == CobId::heartbeat(step.control.id()) {
            self.on_own_heartbeat(bus, frame, at, step)
        } else {
            SlaveVerdict::Ignored
        }
    }

    fn on_nmt(&mut self, bus: Bus, frame: &Frame, at: Instant, step: &mut SlaveStep) -> SlaveVerdict {
        let Some(NmtMessage { command, target }) = NmtMessage::decode(frame) else {
            return SlaveVerdict::Malformed;
        };
        let is_for_this = target.includes(step.control.id());
        let is_reset = matches!(command, Command::ResetNode | Command::ResetCommunication);
        // Not of the master, as far as this node can know: it does not end a search either.
        if is_reset && is_for_this && self.refuses(bus, command, step) {
            return SlaveVerdict::Ignored;
        }
        // ECSS 8.3.3g before the command itself: it decides where the answer goes.
        self.on_master(bus, MasterMessage::Command, at, step);
        if bus != self.selected() {
            return SlaveVerdict::Ignored;
        }
        if !is_for_this {
            return SlaveVerdict::Taken;
        }
        let may_run = !self.clashes.has_yielded() && !self.is_silenced;
        if !may_run && matches!(command, Command::Start | Command::EnterPreOperational) {
            return SlaveVerdict::Ignored;
        }
        if is_reset {
            self.count_reset(step);
        }
        step.act(Action::Obey(command));
        SlaveVerdict::Taken
    }

    fn on_master_heartbeat(
        &mut self,
        bus: Bus,
        frame: &Frame,
        at: Instant,
        step: &mut SlaveStep,
    ) -> SlaveVerdict {
        if heartbeat::decode(frame).is_none() {
            return SlaveVerdict::Malformed;
        }
        if self.guard.is_counting() {
            self.trust_resets(step);
        }
        self.on_master(bus, MasterMessage::Heartbeat, at, step);
        if bus == self.selected() { SlaveVerdict::Heard } else { SlaveVerdict::Ignored }
    }

    fn on_master(&mut self, bus: Bus, message: MasterMessage, at: Instant, step: &mut SlaveStep) {
        self.selector.on_work(self.work(step.received));
        if let Some(selection) = self.selector.on_master(bus, message, at) {
            self.apply(selection, step);
        }
    }

    /// Frames of the master's services received on each bus since power-on.
    pub(super) fn work(&self, received: PerBus<u32>) -> PerBus<u32> {
        PerBus::from_fn(|bus| received[bus].wrapping_sub(self.control_frames[bus]))
    }

    /// Takes a frame of this node that was acknowledged and ended at `at`. `own`: the Node-ID.
    pub fn on_sent(&mut self, frame: &Frame, at: Instant, own: NodeId) {
        if frame.id() == CobId::heartbeat(own) {
            self.clashes.on_sent(at);
        } else {
            self.on_end(frame);
        }
    }

    /// Takes a frame of this node that was sent or given up. It may end the warning before a change of the bus.
    pub fn on_end(&mut self, frame: &Frame) {
        let is_warning = || frame.data().starts_with(&ErrorCode::HEARTBEAT.get().to_le_bytes());
        if self.warning.is_some() && is_warning() {
            self.warning = None;
        }
    }
}
