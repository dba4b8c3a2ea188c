//! The master of the model: the redundancy of flight on the wires of the model.

use ecss_can::heartbeat;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::link::queue;
use ecss_can::redundancy::{
    BusAccess, MasterAction, MasterRedundancy, MasterSetup, RoleChange, Sending, Strap, SwitchCause,
    TwoBoards,
};
use ecss_can::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, PerBus, Periodic, Rebase, earliest};

use crate::profile::{
    DWELL, GRACE, HELD, LIFETIME, MASTER_PARAMETERS, PAIR, PARALLEL, PARAMETERS, PLACES, SELECTIVE,
    SILENT_SHARE,
};
use crate::station::{Outgoing, Station};

/// Controllers of a lone transmitter.
const ALONE: Health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

const SETUP: MasterSetup = MasterSetup {
    parameters: MASTER_PARAMETERS,
    silent_share: SILENT_SHARE,
    dwell: DWELL,
    grace: GRACE,
    access: BusAccess::Parallel,
    lifetime: LIFETIME,
};

/// A master.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Master {
    /// Decides about its bus, its role and what it sends.
    pub redundancy: MasterRedundancy<TwoBoards, PLACES, HELD>,
    strap: Option<Strap>,
    is_assigned: bool,
    sync: Periodic,
    outgoing: Outgoing,
    unacknowledged: PerBus<bool>,
    /// Why it changed the bus in this step.
    pub switched: Option<SwitchCause>,
    /// It took over, yielded or became the standby in this step.
    pub role_changed: Option<RoleChange>,
}

impl Master {
    /// A master before power-on, one of two if it has a strap. `is_assigned`: it has both slaves in its list.
    pub fn new(strap: Option<Strap>, is_assigned: bool) -> Self {
        let boards = TwoBoards::new(strap.map(|_| PAIR), strap.unwrap_or(Strap::Prime));
        let redundancy = MasterRedundancy::new(boards, &SETUP);
        Master {
            redundancy,
            strap,
            is_assigned,
            sync: Periodic::new(PARAMETERS.producer),
            outgoing: Outgoing::default(),
            unacknowledged: PerBus::default(),
            switched: None,
            role_changed: None,
        }
    }

    /// Whether it manages the network.
    pub fn is_active(&self) -> bool {
        self.redundancy.is_active()
    }

    /// Nothing happened yet in this step.
    pub fn forget_news(&mut self) {
        (self.switched, self.role_changed) = (None, None);
    }

    /// Shifts the clock.
    pub fn rebase(&mut self, now: Instant) {
        let to = Rebase::new(now);
        self.redundancy.rebase(now);
        self.sync.rebase(&to);
        self.outgoing.rebase(&to);
    }

    fn act(&mut self, action: MasterAction, now: Instant) {
        match action {
            MasterAction::Heartbeat { bus, frame, expires } => self.outgoing.send_until(bus, frame, expires),
            MasterAction::Send { bus, outgoing } => {
                self.outgoing.send_until(bus, outgoing.frame, outgoing.expires)
            }
            MasterAction::Switched { from, cause, .. } => {
                self.switched = Some(cause);
                self.outgoing.abandon(from);
                Bus::ALL.into_iter().for_each(|bus| self.report_health(bus, now));
            }
            MasterAction::TookOver { change, .. } => {
                self.boot_up(now);
                self.role_changed = Some(change);
            }
            MasterAction::StoodBy { change, .. } => {
                self.outgoing.clear();
                self.unacknowledged = PerBus::default();
                self.role_changed = Some(change);
            }
            MasterAction::HeardMaster(change) => self.role_changed = Some(change),
            MasterAction::Refused(bus) => panic!("more frames wait for {bus:?} than the model has places"),
            _ => {}
        }
    }

    fn report_health(&mut self, bus: Bus, now: Instant) {
        let health = if self.unacknowledged[bus] { ALONE } else { Health::default() };
        self.redundancy.on_health(bus, health, false, now);
    }

    fn boot_up(&mut self, now: Instant) {
        let (queue::Outgoing { frame, expires }, _) = self.redundancy.boot_up(now);
        self.outgoing.send_until(self.active(), frame, expires);
        self.sync.restart(now);
    }

    fn on_heartbeat(&mut self, bus: Bus, node: NodeId, state: NmtState, now: Instant) {
        if !self.is_active() {
            self.redundancy.on_overheard(bus, node, state, now);
            return;
        }
        let news = self.redundancy.on_heartbeat(bus, node, state, now, |_| true);
        let Some(message) = news.command else { return };
        let (frame, expires) = (message.encode(), now + LIFETIME);
        match self.redundancy.send(queue::Outgoing { frame, expires }) {
            Sending::Now(bus) => self.outgoing.send_until(bus, frame, expires),
            Sending::Held => {}
            Sending::Refused(bus) => self.act(MasterAction::Refused(bus), now),
        }
    }

    /// Asks new nodes who they are. A slave answers within the same moment, or its question waits for the next one.
    fn identify(&mut self, now: Instant) {
        while let Some(node) = self.redundancy.peers_mut().take_unasked() {
            self.outgoing.send(self.active(), Frame::of(CobId::sdo_request(node), []), now);
        }
    }
}

impl Station for Master {
    fn start(&mut self, now: Instant) {
        self.power_off();
        if self.is_assigned {
            [PARALLEL, SELECTIVE].into_iter().for_each(|node| self.redundancy.peers_mut().assign(node, true));
        } else {
            // Named in 1016h: the master observes no periods, which an outage would make as long as itself.
            let entry = |node: NodeId| u32::from(node.get()) << 16 | PARAMETERS.consumer.as_millis() as u32;
            self.redundancy.peers_mut().set_times(&[PARALLEL, SELECTIVE].map(entry));
        }
        if self.redundancy.start(now) {
            self.boot_up(now);
            self.poll(now);
        }
    }

    fn power_off(&mut self) {
        *self = Master::new(self.strap, self.is_assigned);
    }

    fn poll(&mut self, now: Instant) {
        while let Some(action) = self.redundancy.poll(now, now) {
            self.act(action, now);
        }
        if self.is_active() && self.redundancy.is_announced() {
            self.identify(now);
            if self.sync.due(now) {
                self.outgoing.send(self.active(), Frame::of(CobId::SYNC, []), now);
            }
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.poll(now);
        let id = frame.id();
        let node = id.node().filter(|node| *node != NodeId::MASTER);
        if self.is_active() {
            self.redundancy.on_frame(bus, node, now);
        }
        let action = if id == CobId::heartbeat(NodeId::MASTER) {
            self.redundancy.on_master(bus, now, now)
        } else if let Some(claim) = PAIR.claim(frame) {
            self.redundancy.on_claim(bus, &claim, now, now)
        } else if id == CobId::SYNC {
            self.redundancy.on_sync_or_time(bus, now, now)
        } else {
            None
        };
        if let Some(action) = action {
            self.act(action, now);
        }
        if let Some(node) = node.filter(|node| id == CobId::heartbeat(*node))
            && let Some(state) = heartbeat::decode(frame)
        {
            self.on_heartbeat(bus, node, state, now);
        } else if let Some(node) = node.filter(|node| id == CobId::sdo_response(*node))
            && bus == self.active()
        {
            self.redundancy.on_answer(node, now);
        }
        self.poll(now);
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.outgoing.acknowledge(bus, frame);
        self.redundancy.on_sent(bus, frame.id(), now);
        self.poll(now);
    }

    fn on_expired(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.redundancy.on_failed(bus, frame.id());
        if let Some(node) = frame.id().node().filter(|node| frame.id() == CobId::sdo_request(*node)) {
            self.redundancy.peers_mut().ask_again(node);
        }
        self.poll(now);
    }

    fn on_unacknowledged(&mut self, bus: Bus, unacknowledged: bool, now: Instant) {
        if self.unacknowledged[bus] != unacknowledged {
            self.unacknowledged[bus] = unacknowledged;
            self.report_health(bus, now);
            self.poll(now);
        }
    }

    fn deadline(&self) -> Option<Instant> {
        let due = self.redundancy.deadline();
        if !self.is_active() {
            return due;
        }
        let sync = self.sync.deadline().filter(|_| self.redundancy.is_announced());
        earliest(&[due, sync, self.outgoing.deadline()])
    }

    fn is_joined(&self, bus: Bus) -> bool {
        self.redundancy.is_joined(bus)
    }

    fn is_silent(&self) -> bool {
        !self.is_active()
    }

    fn active(&self) -> Bus {
        self.redundancy.active()
    }

    fn state(&self) -> NmtState {
        self.redundancy.state()
    }

    fn outgoing(&mut self) -> &mut Outgoing {
        &mut self.outgoing
    }

    fn waiting(&self) -> &Outgoing {
        &self.outgoing
    }
}
