//! The master of the model: the state machines of flight, and what joins them in `node::master`.

use ecss_can::heartbeat;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::redundancy::{
    Action, Answer, Broken, Claim, Manager, Rivals, RoleCause, RoleChange, Standby, Strap, SwitchCause,
};
use ecss_can::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, PerBus, Periodic, Rebase, earliest};

use crate::profile::{
    DWELL, GRACE, MASTER_PARAMETERS, PAIR, PARALLEL, PARAMETERS, PLACES, SELECTIVE, SILENT_SHARE,
};
use crate::station::{Outgoing, Station};

/// Controllers of a lone transmitter.
const ALONE: Health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

/// A master.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Master {
    /// Decides which bus is active.
    pub manager: Manager<PLACES>,
    /// Decides which of two masters is active.
    standby: Option<Standby>,
    is_assigned: bool,
    broken: Option<Broken>,
    rivals: Rivals,
    sync: Periodic,
    outgoing: Outgoing,
    /// Commands that wait until the bus is announced.
    held: Vec<(Frame, Instant)>,
    unacknowledged: PerBus<bool>,
    /// Why it changed the bus in this step.
    pub switched: Option<SwitchCause>,
    /// It took over, yielded or became the standby in this step.
    pub role_changed: Option<RoleChange>,
}

impl Master {
    /// A master before power-on, one of two if it has a strap. `is_assigned`: it has both slaves in its list; `broken`: a rule that
    /// does not hold.
    pub fn new(strap: Option<Strap>, is_assigned: bool, broken: Option<Broken>) -> Self {
        let mut manager = Manager::new(MASTER_PARAMETERS, SILENT_SHARE, DWELL, GRACE);
        manager.break_rule(broken);
        let standby = strap.map(|strap| {
            let mut standby = Standby::new(PAIR, strap);
            standby.break_rule(broken);
            standby
        });
        Master {
            manager,
            standby,
            is_assigned,
            broken,
            rivals: Rivals::default(),
            sync: Periodic::new(PARAMETERS.producer),
            outgoing: Outgoing::default(),
            held: Vec::new(),
            unacknowledged: PerBus::default(),
            switched: None,
            role_changed: None,
        }
    }

    /// Whether it manages the network.
    pub fn is_active(&self) -> bool {
        self.standby.as_ref().is_none_or(Standby::is_active)
    }

    /// Nothing happened yet in this step.
    pub fn forget_news(&mut self) {
        (self.switched, self.role_changed) = (None, None);
    }

    /// Shifts the clock.
    pub fn rebase(&mut self, now: Instant) {
        let to = Rebase::new(now);
        self.manager.rebase(now);
        if let Some(standby) = &mut self.standby {
            standby.rebase(now);
        }
        self.rivals.rebase(&to, PARAMETERS.quiet_time());
        self.sync.rebase(&to);
        self.outgoing.rebase(&to);
        self.held.iter_mut().for_each(|(_, expires)| *expires = to.due(*expires));
    }

    fn send_nmt(&mut self, message: NmtMessage, now: Instant) {
        if self.manager.is_announced() {
            self.outgoing.send(self.manager.active(), message.encode(), now);
        } else {
            self.held.push((message.encode(), now + PARAMETERS.producer));
        }
    }

    fn act(&mut self, action: Action, now: Instant) {
        match action {
            Action::Heartbeat { bus, frame } => {
                self.outgoing.send(bus, frame, now);
                let slaves = self.manager.peers().heard(now, PARAMETERS.consumer);
                if let Some(claim) = self.standby.as_mut().and_then(|standby| standby.call(now, slaves)) {
                    Bus::ALL.into_iter().for_each(|bus| self.outgoing.send(bus, PAIR.frame(claim), now));
                }
            }
            Action::Switched { from, cause, .. } => {
                self.switched = Some(cause);
                self.held.clear();
                self.outgoing.abandon(from);
                for bus in Bus::ALL {
                    self.report_health(bus, now);
                }
            }
            Action::Lost(_) | Action::Forgotten(_) | Action::Unheard(_) | Action::GaveUp { .. } => {}
        }
    }

    fn report_health(&mut self, bus: Bus, now: Instant) {
        let health = if self.unacknowledged[bus] { ALONE } else { Health::default() };
        self.manager.on_health(bus, health, false, now);
    }

    fn restarted(&self) -> Master {
        Master::new(self.standby.as_ref().map(Standby::strap), self.is_assigned, self.broken)
    }

    fn boot_up(&mut self, now: Instant) {
        let boot_up = heartbeat::encode(NodeId::MASTER, NmtState::Initialising);
        self.outgoing.send(self.manager.active(), boot_up, now);
        self.sync.restart(now);
    }

    fn take_over(&mut self, now: Instant) {
        let Some(standby) = &mut self.standby else { return };
        let Some(change) = standby.poll(now) else { return };
        self.manager.take_over(standby.heard().unwrap_or(PARAMETERS.bdefault), standby.overheard(), now);
        self.boot_up(now);
        self.role_changed = Some(change);
    }

    fn stand_by(&mut self, change: RoleChange) {
        self.held.clear();
        self.outgoing.clear();
        self.manager.stand_by();
        self.rivals = Rivals::default();
        self.unacknowledged = PerBus::default();
        self.role_changed = Some(change);
    }

    fn answer(&mut self, bus: Bus, answer: Answer, now: Instant) {
        match answer {
            Answer::Nothing => {}
            Answer::Changed(change) if change.cause == RoleCause::MasterHeard => {
                self.role_changed = Some(change);
            }
            Answer::Changed(change) => self.stand_by(change),
            Answer::Claim(claim) => self.outgoing.send(bus, PAIR.frame(claim), now),
        }
    }

    /// 701h of another master.
    fn on_other_master(&mut self, bus: Bus, now: Instant) {
        if let Some(standby) = &mut self.standby {
            let answer = standby.on_master(bus, now);
            self.answer(bus, answer, now);
        }
    }

    fn claim(&self, frame: &Frame) -> Option<Claim> {
        self.standby.as_ref()?.pair().claim(frame)
    }

    fn on_claim(&mut self, bus: Bus, claim: &Claim, now: Instant) {
        let slaves = self.manager.peers().heard(now, PARAMETERS.consumer);
        if let Some(standby) = &mut self.standby {
            let answer = standby.on_claim(bus, claim, now, slaves);
            self.answer(bus, answer, now);
        }
    }

    /// Asks new nodes who they are. A slave answers within the same moment, or its question waits for the next one.
    fn identify(&mut self, now: Instant) {
        while let Some(node) = self.manager.peers_mut().take_unasked() {
            self.outgoing.send(self.manager.active(), Frame::of(CobId::sdo_request(node), []), now);
        }
    }

    /// A frame while another master is active.
    fn overhear(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let id = frame.id();
        if id == CobId::heartbeat(NodeId::MASTER) {
            self.manager.follow(bus);
            self.on_other_master(bus, now);
        } else if let Some(claim) = self.claim(frame) {
            self.on_claim(bus, &claim, now);
        } else if id == CobId::SYNC {
            let slaves = self.manager.peers().heard(now, PARAMETERS.consumer);
            if let Some(standby) = &mut self.standby {
                let answer = standby.on_other_frame(bus, now, slaves);
                self.answer(bus, answer, now);
            }
            if slaves == 0 {
                self.manager.follow(bus);
            }
        } else if let Some(node) = id.node()
            && id == CobId::heartbeat(node)
            && let Some(state) = heartbeat::decode(frame)
        {
            self.manager.on_heartbeat(bus, node, state, now);
            if state == NmtState::Operational
                && bus == self.manager.active()
                && let Some(standby) = &mut self.standby
            {
                standby.on_operational(node);
            }
        } else if let Some(node) = id.node()
            && id == CobId::sdo_response(node)
            && bus == self.manager.active()
        {
            self.manager.on_answer(node, now);
        }
    }
}

impl Station for Master {
    fn start(&mut self, now: Instant) {
        *self = self.restarted();
        if self.is_assigned {
            [PARALLEL, SELECTIVE].into_iter().for_each(|node| self.manager.peers_mut().assign(node, true));
        } else {
            // Named in 1016h: the master observes no periods, which an outage would make as long as itself.
            let entry = |node: NodeId| u32::from(node.get()) << 16 | PARAMETERS.consumer.as_millis() as u32;
            self.manager.peers_mut().set_times(&[PARALLEL, SELECTIVE].map(entry));
        }
        if let Some(standby) = &mut self.standby {
            return standby.start(now);
        }
        self.manager.start(now);
        self.boot_up(now);
        self.poll(now);
    }

    fn power_off(&mut self) {
        *self = self.restarted();
    }

    fn poll(&mut self, now: Instant) {
        self.take_over(now);
        if !self.is_active() {
            return;
        }
        while let Some(action) = self.manager.poll(now) {
            self.act(action, now);
        }
        while self.rivals.poll(now, PARAMETERS.quiet_time()).is_some() {
            if self.rivals.are_silent() {
                self.manager.on_rivals_silent(now);
            }
        }
        if self.manager.is_announced() {
            let bus = self.manager.active();
            for (frame, expires) in self.held.drain(..) {
                if expires > now {
                    self.outgoing.send_for(bus, frame, now, expires.since(now));
                }
            }
            if self.sync.due(now) {
                self.outgoing.send(bus, Frame::of(CobId::SYNC, []), now);
            }
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.poll(now);
        if !self.is_active() {
            return self.overhear(bus, frame, now);
        }
        let id = frame.id();
        let node = id.node().filter(|node| *node != NodeId::MASTER);
        self.manager.on_frame(bus, node, now);
        if id == CobId::heartbeat(NodeId::MASTER) {
            self.rivals.on_heartbeat(bus, now);
            self.manager.on_rival();
            self.on_other_master(bus, now);
        } else if let Some(claim) = self.claim(frame) {
            self.on_claim(bus, &claim, now);
        } else if let Some(node) = node
            && id == CobId::heartbeat(node)
            && let Some(state) = heartbeat::decode(frame)
        {
            if self.manager.on_heartbeat(bus, node, state, now).start {
                self.send_nmt(NmtMessage { command: Command::Start, target: Target::Node(node) }, now);
            }
            self.identify(now);
        } else if let Some(node) = node
            && id == CobId::sdo_response(node)
            && bus == self.manager.active()
        {
            self.manager.on_answer(node, now);
        }
        self.poll(now);
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.outgoing.acknowledge(bus, frame);
        self.manager.on_sent(bus, now);
        if frame.id() == CobId::heartbeat(NodeId::MASTER) {
            self.manager.on_heartbeat_sent(bus, now);
        }
        self.poll(now);
    }

    fn on_expired(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        if frame.id() == CobId::heartbeat(NodeId::MASTER) {
            self.manager.on_heartbeat_failed(bus);
        }
        if let Some(node) = frame.id().node().filter(|node| frame.id() == CobId::sdo_request(*node)) {
            self.manager.peers_mut().ask_again(node);
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
        if !self.is_active() {
            return self.standby.as_ref()?.deadline();
        }
        let sync = self.sync.deadline().filter(|_| self.manager.is_announced());
        let rivals = self.rivals.deadline(PARAMETERS.quiet_time());
        earliest(&[self.manager.deadline(), rivals, sync, self.outgoing.deadline()])
    }

    fn is_joined(&self, _bus: Bus) -> bool {
        true
    }

    fn is_silent(&self) -> bool {
        !self.is_active()
    }

    fn active(&self) -> Bus {
        self.manager.active()
    }

    fn state(&self) -> NmtState {
        NmtState::Operational
    }

    fn outgoing(&mut self) -> &mut Outgoing {
        &mut self.outgoing
    }

    fn waiting(&self) -> &Outgoing {
        &self.outgoing
    }
}
