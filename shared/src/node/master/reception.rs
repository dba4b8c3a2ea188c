//! Received frames of the master, and the results of the frames that it sent.

use super::{Master, MasterEvent, Out};
use crate::emcy::{Emergency, ErrorCode};
use crate::link::Stamp;
use crate::node::{Device, FailCause};
use crate::redundancy::{MasterBoards, MasterVerdict, Parameters, PeerHeartbeat, SlaveNews};
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Takes a received frame. Schedules the next run as early as its effect needs: most frames have none.
    pub(super) fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        if !self.redundancy.is_joined(bus) {
            return self.services.buses.ignored(bus);
        }
        let id = frame.id();
        let producer = self.boot.producer(id).filter(|node| *node != NodeId::MASTER);
        if self.redundancy.on_frame(bus, producer, stamp.at) {
            self.services.next = Instant::ZERO;
        }
        if let Some(node) = producer {
            self.watch(bus, id, node, stamp.at, now, out);
        }
        if id == CobId::sdo_request(NodeId::MASTER) && bus == self.redundancy.active() {
            return self.on_sdo(bus, frame, now, out);
        }
        match self.redundancy.on_received(bus, frame, stamp.at, now) {
            MasterVerdict::OtherMaster(action) => {
                self.services.buses.ignored(bus);
                self.act_if(action, now, out);
            }
            MasterVerdict::Claim(action) => self.act_if(action, now, out),
            MasterVerdict::Heartbeat { node, state } => {
                self.services.buses.taken(bus, frame);
                self.on_heartbeat(bus, node, state, *stamp, now, out);
            }
            MasterVerdict::Response(node) => self.on_response(bus, node, frame, now, out),
            MasterVerdict::Malformed => self.services.buses.malformed(bus),
            MasterVerdict::Other => self.on_other_frame(bus, frame, stamp, producer, now, out),
        }
    }

    /// Takes a frame of which the redundancy has no use. `producer`: its node, if the COB-ID has one.
    fn on_other_frame(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        producer: Option<NodeId>,
        now: Instant,
        out: &mut Out,
    ) {
        let id = frame.id();
        if bus != self.redundancy.active() {
            return self.services.buses.ignored(bus);
        }
        if self.redundancy.state().allows_pdo() && self.services.on_pdo(bus, frame, stamp, now, out) {
            // Only an Operational node sends PDOs.
            if let Some(node) = producer {
                self.boot.on_synchronous(node);
                self.wake_boot();
            }
        } else if D::RAW_FRAMES.contains(&id) {
            out.event(MasterEvent::Frame { bus, frame: *frame });
        } else if id.node().is_some_and(|node| self.consumes_emergency(id, node)) {
            match Emergency::decode(frame) {
                Some((node, emergency)) => {
                    self.follow_errors(node, &emergency, now, out);
                    self.services.wake(self.errors_deadline());
                    out.event(MasterEvent::Emergency { node, bus, emergency });
                }
                None => self.services.buses.malformed(bus),
            }
        } else {
            self.services.buses.ignored(bus);
        }
    }

    pub(super) fn consumes_emergency(&self, id: CobId, node: NodeId) -> bool {
        let emergencies = &self.services.dictionary.objects.application.emergencies;
        node != NodeId::MASTER && id == CobId::emcy(node) && emergencies.consumes(node)
    }

    fn on_heartbeat(
        &mut self,
        bus: Bus,
        node: NodeId,
        state: NmtState,
        stamp: Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        let is_here = bus == self.redundancy.active();
        // A node that is Operational on the other bus takes no commands here.
        let is_judged = is_here || state != NmtState::Operational;
        let state = if is_judged { self.judge_state(node, state, stamp.at, out) } else { state };
        let Self { redundancy, boot, .. } = self;
        let may_start = |heard: PeerHeartbeat| boot.on_heartbeat(node, state, is_here, heard.returned);
        let SlaveNews { heard, command } = redundancy.on_heartbeat(bus, node, state, stamp.at, may_start);
        if heard.returned {
            out.event(MasterEvent::SlaveReturned { node, bus });
        }
        if heard.changed || heard.returned {
            self.show_state(node, state.byte());
            out.event(MasterEvent::SlaveState { node, bus, state });
        }
        if is_here {
            if state.allows_sdo() || state == NmtState::Initialising {
                // A slave that left Operational may have been reset where its boot-up message was not heard.
                let may_have_booted = state == NmtState::Initialising || heard.changed && !state.allows_pdo();
                self.errors.on_heard(node, may_have_booted, stamp.at);
            }
            self.on_monitored(node, state, stamp.at);
            self.on_ranged(node, &stamp);
        }
        self.wake_boot();
        self.services.wake(self.redundancy.peers().deadline());
        if let Some(message) = command {
            self.send_nmt(message, now, out);
        }
    }

    /// Returns the state that the master acts on, and reports a clash when it begins.
    fn judge_state(&mut self, node: NodeId, state: NmtState, at: Instant, out: &mut Out) -> NmtState {
        let Parameters { producer, consumer, .. } = *self.redundancy.parameters();
        let operational = self.redundancy.peers().operational_at(node);
        let judged = self.clashes.on_heartbeat(node, state, at, operational, [producer, consumer]);
        if judged.is_new {
            self.services.raise(ErrorCode::CAN_ID_COLLISION, [node.get(), 0, 0, 0, 0]);
            self.services.next = Instant::ZERO;
            out.event(MasterEvent::Clash { node });
        }
        judged.state
    }

    /// Ends the clashes of slaves that are over.
    pub(super) fn end_clashes(&mut self, now: Instant, out: &mut Out) {
        while let Some(node) = self.clashes.poll(now, self.redundancy.parameters().consumer) {
            self.services.clear(ErrorCode::CAN_ID_COLLISION, node.get());
            self.services.next = Instant::ZERO;
            out.event(MasterEvent::ClashOver { node });
        }
    }

    /// Schedules the boot-up process and the identification of nodes.
    fn wake_boot(&mut self) {
        if self.boot.is_due() {
            self.services.next = Instant::ZERO;
        }
        self.services.wake(self.identification_deadline());
        self.services.wake(self.errors_deadline());
    }

    pub(super) fn on_transmitted(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        if self.redundancy.on_sent(bus, frame.id(), stamp.at) {
            self.is_booting = false;
            self.services.note_heartbeat(&stamp);
            self.services.on_heartbeat_sent();
        } else if self.services.is_emergency(frame.id()) {
            if bus == self.redundancy.active() {
                self.services.on_frame_end(frame, true, now);
                // The master is the one that has to know.
                self.services.dictionary.emcy.confirm();
            }
        } else if self.services.is_sync(frame.id()) {
            self.boot.on_sync_sent();
            // Its own SYNC has the right length.
            if let Ok(counter) = self.services.on_sync(bus, frame, &stamp)
                && self.redundancy.state().allows_pdo()
            {
                self.services.exchange(bus, counter, self.withheld_time(), now, out);
            }
            if self.services.on_sync_produced() {
                out.event(MasterEvent::SyncUncaptured);
            }
            out.event(MasterEvent::SyncSent { stamp });
        }
    }

    pub(super) fn on_failed(
        &mut self,
        bus: Bus,
        frame: &Frame,
        cause: FailCause,
        now: Instant,
        out: &mut Out,
    ) {
        // What is over the budget is reported as such.
        let is_told = cause != FailCause::OverBudget && self.is_lost(frame);
        if is_told {
            out.event(MasterEvent::NotSent { bus, id: frame.id(), data: frame.padded() });
        }
        if !self.is_active() {
            return;
        }
        if !is_told && bus == self.redundancy.active() {
            self.services.on_frame_end(frame, false, now);
        }
        self.on_sdo_sent(bus, frame);
        // A heartbeat given up because its bus was left belongs to an earlier stay on it.
        if cause != FailCause::BusLeft {
            self.redundancy.on_failed(bus, frame.id());
        }
    }
}
