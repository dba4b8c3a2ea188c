//! Received frames of the master, and the results of the frames that it sent.

#[cfg(feature = "model")]
mod broken;

use super::boards::MasterBoards;
use super::{Master, MasterEvent, Out};
use crate::emcy::{Emergency, ErrorCode};
use crate::heartbeat;
use crate::link::Stamp;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::{Device, FailCause};
use crate::redundancy::Parameters;
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Takes a received frame. Schedules the next run as early as its effect needs: most frames have none.
    pub(super) fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let active = self.manager.active();
        if !self.services.buses.is_joined(bus, active) {
            return self.services.buses.ignored(bus);
        }
        let (id, node) = (frame.id(), frame.id().node());
        let producer = self.boot.producer(id).filter(|node| *node != NodeId::MASTER);
        if self.manager.on_frame(bus, producer, stamp.at) {
            self.services.next = Instant::ZERO;
        }
        if let Some(node) = producer {
            self.watch(bus, id, node, stamp.at, now, out);
        }
        if id == CobId::sdo_request(NodeId::MASTER) && bus == active {
            return self.on_sdo(bus, frame, now, out);
        }
        if id == CobId::heartbeat(NodeId::MASTER) {
            self.on_rival(bus, stamp.at, out);
            return self.on_other_master(bus, stamp.at, now, out);
        }
        if self.on_claim(bus, frame, stamp.at, now, out) {
            return;
        }
        if bus == active && self.nmt.state().allows_pdo() && self.services.on_pdo(bus, frame, stamp, now, out)
        {
            // Only an Operational node sends PDOs.
            if let Some(node) = producer {
                self.boot.on_synchronous(node);
                self.wake_boot();
            }
            return;
        }
        if bus == active && D::RAW_FRAMES.contains(&id) {
            return out.event(MasterEvent::Frame { bus, frame: *frame });
        }
        let Some(node) = node.filter(|node| *node != NodeId::MASTER) else {
            return self.services.buses.ignored(bus);
        };
        if id == CobId::heartbeat(node) {
            return self.on_heartbeat(bus, node, frame, *stamp, now, out);
        }
        if bus != active {
            return self.services.buses.ignored(bus);
        }
        if id == CobId::sdo_response(node) {
            self.on_response(bus, node, frame, now, out);
        } else if id == CobId::emcy(node)
            && self.services.dictionary.objects.application.emergencies.consumes(node)
        {
            match Emergency::decode(frame) {
                Some((node, emergency)) => out.event(MasterEvent::Emergency { node, bus, emergency }),
                None => self.services.buses.malformed(bus),
            }
        } else {
            self.services.buses.ignored(bus);
        }
    }

    fn on_heartbeat(
        &mut self,
        bus: Bus,
        node: NodeId,
        frame: &Frame,
        stamp: Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        let Some(state) = heartbeat::decode(frame) else { return self.services.buses.malformed(bus) };
        let is_here = bus == self.manager.active();
        // A node that is Operational on the other bus takes no commands here.
        let is_judged = is_here || state != NmtState::Operational;
        let state = if is_judged { self.judge_state(node, state, stamp.at, out) } else { state };
        let heard = self.manager.on_heartbeat(bus, node, state, stamp.at);
        #[cfg(feature = "model")]
        let heard = self.trusted(node, heard);
        let may_start = self.boot.on_heartbeat(node, state, is_here, heard.returned);
        if heard.returned {
            out.event(MasterEvent::SlaveReturned { node, bus });
        }
        if heard.changed || heard.returned {
            self.show_state(node, state.byte());
            out.event(MasterEvent::SlaveState { node, bus, state });
        }
        if is_here {
            self.on_monitored(node, state, stamp.at);
            self.on_ranged(node, &stamp);
        }
        self.wake_boot();
        self.services.wake(self.manager.peers().deadline());
        let command = match state {
            // ECSS 8.3.3f, unasked; also a slave that came back before it toggled.
            _ if may_start => Command::Start,
            // It has to be checked first, and answers no SDO while it is stopped.
            NmtState::Stopped => Command::EnterPreOperational,
            _ => return,
        };
        if heard.start {
            self.send_nmt(NmtMessage { command, target: Target::Node(node) }, now, out);
        }
    }

    /// Returns the state that the master acts on, and reports a clash when it begins.
    fn judge_state(&mut self, node: NodeId, state: NmtState, at: Instant, out: &mut Out) -> NmtState {
        let Parameters { producer, consumer, .. } = *self.manager.parameters();
        let operational = self.manager.peers().operational_at(node);
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
        while let Some(node) = self.clashes.poll(now, self.manager.parameters().consumer) {
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
    }

    /// Takes the master's heartbeat COB-ID in a frame of another node.
    fn on_rival(&mut self, bus: Bus, at: Instant, out: &mut Out) {
        self.services.buses.ignored(bus);
        self.manager.on_rival();
        if self.rivals.on_heartbeat(bus, at) {
            self.services.raise(ErrorCode::CAN_ID_COLLISION, [bus.bdefault(), 0, 0, 0, 0]);
            self.services.next = Instant::ZERO;
            out.event(MasterEvent::SecondMaster { bus });
        }
    }

    /// Ends the collisions that are over.
    pub(super) fn run_rivals(&mut self, until: Instant, out: &mut Out) {
        while let Some(bus) = self.rivals.poll(until, self.manager.parameters().quiet_time()) {
            self.services.clear(ErrorCode::CAN_ID_COLLISION, bus.bdefault());
            self.services.next = Instant::ZERO;
            out.event(MasterEvent::SecondMasterSilent { bus });
            if self.rivals.are_silent() {
                self.manager.on_rivals_silent(until);
            }
        }
    }

    pub(super) fn on_transmitted(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        self.manager.on_sent(bus, stamp.at);
        if frame.id() == CobId::heartbeat(NodeId::MASTER) {
            self.manager.on_heartbeat_sent(bus, stamp.at);
            self.is_booting = false;
            self.services.note_heartbeat(&stamp);
            self.services.on_heartbeat_sent();
        } else if frame.id() == self.sync.id() {
            self.boot.on_sync_sent();
            // Its own SYNC has the right length.
            if let Ok(counter) = self.services.on_sync(bus, frame, &stamp)
                && self.nmt.state().allows_pdo()
            {
                self.services.exchange(bus, counter, self.withheld_time(), now, out);
            }
            if self.services.on_sync_produced() {
                out.event(MasterEvent::SyncUncaptured);
            }
            out.event(MasterEvent::SyncSent { stamp });
        }
    }

    pub(super) fn on_failed(&mut self, bus: Bus, frame: &Frame, cause: FailCause) {
        // A heartbeat given up because its bus was left belongs to an earlier stay on it.
        if frame.id() == CobId::heartbeat(NodeId::MASTER) && cause != FailCause::BusLeft {
            self.manager.on_heartbeat_failed(bus);
        }
    }
}
