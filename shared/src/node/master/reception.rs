//! Received frames of the master, active or standby, and the results of the frames that it sent.

use super::ranging::RangingServices;
use super::{Master, MasterEvent, Turn};
use crate::emcy::{Emergency, ErrorCode};
use crate::link::Stamp;
use crate::node::services::{SpacecraftServices, TimeServices};
use crate::node::{FailCause, SpacecraftDevice};
use crate::redundancy::{MasterBoards, MasterVerdict, Parameters};
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Takes a received frame. Schedules the next run as early as its effect needs: most frames have none.
    pub(super) fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if !self.redundancy.is_joined(bus) {
            return self.services.buses_mut().count_ignored(bus);
        }
        let id = frame.id();
        let producer = self.boot.producer(id).filter(|node| *node != NodeId::MASTER);
        let verdict = self.redundancy.step(self.services.wakes_mut(), |redundancy| {
            redundancy.on_frame(bus, producer, stamp.at);
            redundancy.on_received(bus, frame, stamp.at, turn.now)
        });
        if let Some(node) = producer {
            self.watch(bus, id, node, stamp.at, turn);
        }
        if id == CobId::sdo_request(NodeId::MASTER) && bus == self.redundancy.active() {
            return self.on_sdo(bus, frame, turn);
        }
        match verdict {
            MasterVerdict::OtherMaster(action) => {
                self.services.buses_mut().count_ignored(bus);
                self.act_if(action, turn);
            }
            MasterVerdict::Claim(action) => self.act_if(action, turn),
            MasterVerdict::Heartbeat { node, state } => {
                self.services.buses_mut().count_heartbeat(bus, frame);
                self.on_heartbeat(bus, node, state, *stamp, turn);
            }
            MasterVerdict::Response(node) => self.on_response(bus, node, frame, turn),
            MasterVerdict::Malformed => self.services.buses_mut().count_malformed(bus),
            MasterVerdict::Other => self.on_other_frame(bus, frame, stamp, producer, turn),
        }
    }

    /// Takes a frame of which the redundancy has no use. `producer`: its node, if the COB-ID has one.
    fn on_other_frame(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        producer: Option<NodeId>,
        turn: &mut Turn,
    ) {
        let id = frame.id();
        if bus != self.redundancy.active() {
            return self.services.buses_mut().count_ignored(bus);
        }
        if self.redundancy.state().allows_pdo() && self.services.on_pdo(bus, frame, stamp, turn) {
            // Only an Operational node sends PDOs.
            if let Some(node) = producer {
                self.boot.step(self.services.wakes_mut(), |boot| boot.on_synchronous(node));
            }
        } else if D::RAW_FRAMES.contains(&id) {
            turn.out.event(MasterEvent::Frame { bus, frame: *frame });
        } else if id.node().is_some_and(|node| self.consumes_emergency(id, node)) {
            match Emergency::decode(frame) {
                Some((node, emergency)) => {
                    self.follow_errors(node, &emergency, turn);
                    turn.out.event(MasterEvent::Emergency { node, bus, emergency });
                }
                None => self.services.buses_mut().count_malformed(bus),
            }
        } else {
            self.services.buses_mut().count_ignored(bus);
        }
    }

    pub(super) fn consumes_emergency(&self, id: CobId, node: NodeId) -> bool {
        let emergencies = &self.services.objects().application.emergencies;
        node != NodeId::MASTER && id == CobId::emcy(node) && emergencies.consumes(node)
    }

    fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, stamp: Stamp, turn: &mut Turn) {
        let is_here = bus == self.redundancy.active();
        // A node that is Operational on the other bus takes no commands here.
        let is_judged = is_here || state != NmtState::Operational;
        let state = if is_judged { self.judge_state(node, state, stamp.at, turn) } else { state };
        let Self { redundancy, boot, identification, services, .. } = self;
        let wakes = services.wakes_mut();
        let heard = redundancy.step(wakes, |redundancy| redundancy.on_heartbeat(bus, node, state, stamp.at));
        let may_start = boot.step(wakes, |boot| boot.on_heartbeat(node, state, is_here, heard.returned));
        let is_wanted = redundancy.peers().is_any_unasked();
        identification.step(wakes, |identification| identification.set_wanted(is_wanted));
        if heard.returned {
            turn.out.event(MasterEvent::SlaveReturned { node, bus });
        }
        if heard.changed || heard.returned {
            self.show_state(node, state.byte());
            turn.out.signal(MasterEvent::SlaveState { node, bus, state });
        }
        if is_here {
            if state.allows_sdo() || state == NmtState::Initialising {
                // A slave that left Operational may have been reset where its boot-up message was not heard.
                let may_have_booted = state == NmtState::Initialising || heard.changed && !state.allows_pdo();
                let wakes = self.services.wakes_mut();
                self.errors.step(wakes, |errors| errors.on_heard(node, may_have_booted, stamp.at));
            }
            self.services.on_peer_heartbeat(node, state, stamp.at);
            self.services.on_ranged(node, &stamp);
        }
        // A minimal slave has no NMT commands (ECSS 9.4.6.1a).
        if self.minimal(node).is_some() {
            return;
        }
        if let Some(message) = heard.command(node, state, may_start) {
            self.send_nmt(message, turn);
        }
        if heard.start && state == NmtState::Stopped {
            self.rescue.step(self.services.wakes_mut(), |rescue| rescue.on_stopped(stamp.at));
        }
    }

    /// Returns the state that the master acts on, and reports a clash when it begins.
    fn judge_state(&mut self, node: NodeId, state: NmtState, at: Instant, turn: &mut Turn) -> NmtState {
        let Parameters { producer, consumer, .. } = *self.redundancy.parameters();
        let operational = self.redundancy.peers().operational_at(node);
        let judged = self.clashes.on_heartbeat(node, state, at, operational, [producer, consumer]);
        if judged.is_new {
            self.services.raise(ErrorCode::CAN_ID_COLLISION, [node.get(), 0, 0, 0, 0]);
            turn.out.event(MasterEvent::Clash { node });
        }
        judged.state
    }

    /// Ends the clashes of slaves that are over.
    pub(super) fn end_clashes(&mut self, until: Instant, turn: &mut Turn) {
        while let Some(node) = self.clashes.poll(until, self.redundancy.parameters().consumer) {
            self.services.clear(ErrorCode::CAN_ID_COLLISION, node.get());
            turn.out.event(MasterEvent::ClashOver { node });
        }
    }

    pub(super) fn on_transmitted(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, turn: &mut Turn) {
        if self.redundancy_mut().on_sent(bus, frame.id(), stamp.at) {
            self.is_booting = false;
            self.services.emcy_mut();
            self.services.note_heartbeat(&stamp);
            self.services.on_heartbeat_sent();
        } else if self.services.is_emergency(frame.id()) {
            if bus == self.redundancy.active() {
                self.services.on_frame_end(frame, true, turn.now);
                // The master is the one that has to know.
                self.services.confirm_emergencies();
            }
        } else if self.services.is_sync(frame.id()) {
            self.boot_mut().on_sync_sent();
            // Its own SYNC has the right length.
            if let Ok(counter) = self.services.on_sync(bus, frame, &stamp)
                && self.redundancy.state().allows_pdo()
            {
                self.services.exchange(bus, counter, self.withheld_time(), turn);
            }
            if self.services.on_sync_produced() {
                turn.out.event(MasterEvent::SyncUncaptured);
            }
            turn.out.event(MasterEvent::SyncSent { stamp });
        }
    }

    pub(super) fn on_failed(&mut self, bus: Bus, frame: &Frame, cause: FailCause, turn: &mut Turn) {
        // What is over the budget is reported as such.
        let is_told = cause != FailCause::OverBudget && self.is_lost(frame);
        if is_told {
            turn.out.event(MasterEvent::NotSent { bus, id: frame.id(), data: frame.padded() });
        }
        if !self.is_active() {
            return;
        }
        if !is_told && bus == self.redundancy.active() {
            self.services.on_frame_end(frame, false, turn.now);
        }
        self.on_sdo_sent(bus, frame);
        // A heartbeat given up because its bus was left belongs to an earlier stay on it.
        if cause != FailCause::BusLeft {
            self.redundancy_mut().on_failed(bus, frame.id());
        }
    }

    /// Takes a frame while another master is active.
    pub(super) fn overhear(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if self.is_of_master(frame.id()) {
            return self.overhear_unacknowledged(bus, frame, stamp, turn);
        }
        let verdict = self.redundancy_mut().on_received(bus, frame, stamp.at, turn.now);
        match verdict {
            MasterVerdict::OtherMaster(action) | MasterVerdict::Claim(action) => {
                self.services.buses_mut().count_heartbeat(bus, frame);
                // A standby sends no heartbeat with which it would look for flipped bits.
                self.scrub(turn);
                self.act_if(action, turn);
            }
            MasterVerdict::Heartbeat { node, state } => {
                self.services.buses_mut().count_heartbeat(bus, frame);
                let heard = self.redundancy_mut().on_overheard(bus, node, state, stamp.at);
                self.boot_mut().on_overheard(node, state);
                if heard.changed {
                    self.show_state(node, state.byte());
                    turn.out.signal(MasterEvent::SlaveState { node, bus, state });
                }
            }
            // An answer to the active master: it is a slave.
            MasterVerdict::Response(node) => {
                self.redundancy_mut().on_answer(node, stamp.at);
            }
            MasterVerdict::Malformed => self.services.buses_mut().count_malformed(bus),
            MasterVerdict::Other => self.overhear_emergency(bus, frame, turn),
        }
    }

    /// Takes the emergencies of slaves, so that a takeover loses none.
    fn overhear_emergency(&mut self, bus: Bus, frame: &Frame, turn: &mut Turn) {
        match Emergency::decode(frame) {
            Some((node, emergency)) if self.consumes_emergency(frame.id(), node) => {
                self.follow_errors(node, &emergency, turn);
            }
            _ => self.services.buses_mut().count_ignored(bus),
        }
    }

    /// Returns whether only an active master sends this beside heartbeat and claims: SYNC, the spacecraft time.
    fn is_of_master(&self, id: CobId) -> bool {
        self.services.is_sync(id) || self.services.time_pdo().is_some_and(|pdo| pdo.id == id)
    }

    /// Takes a frame that only a master sends, perhaps in place of its heartbeat.
    fn overhear_unacknowledged(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        let action = self.redundancy_mut().on_sync_or_time(bus, stamp.at, turn.now);
        self.act_if(action, turn);
        if bus != self.redundancy.active() {
            self.services.buses_mut().count_ignored(bus);
        } else if self.services.is_sync(frame.id()) {
            self.boot_mut().on_sync_overheard();
            // A wrong length is reported by the master that is active.
            let _ = self.services.on_sync(bus, frame, stamp);
        } else if !self.services.overhear_time(frame, stamp, turn) {
            self.services.buses_mut().count_ignored(bus);
        }
    }
}
