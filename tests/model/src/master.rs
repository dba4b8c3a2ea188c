//! The master of the model: the state machines of flight, and what joins them in `node::master`.

use ecss_can::heartbeat;
use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::redundancy::{Action, Broken, Manager, Rivals, SwitchCause};
use ecss_can::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, PerBus, Periodic, Rebase, earliest};

use crate::profile::{DWELL, PARALLEL, PARAMETERS, PLACES, SELECTIVE, SILENT_SHARE};
use crate::station::{Outgoing, Station};

/// Controllers of a lone transmitter.
const ALONE: Health = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

/// A master.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Master {
    /// Decides which bus is active.
    pub manager: Manager<PLACES>,
    broken: Option<Broken>,
    rivals: Rivals,
    sync: Periodic,
    outgoing: Outgoing,
    /// Commands that wait until the bus is announced.
    held: Vec<(Frame, Instant)>,
    unacknowledged: PerBus<bool>,
    /// Why it changed the bus in this step.
    pub switched: Option<SwitchCause>,
}

impl Master {
    /// A master before power-on. `broken`: a rule that does not hold.
    pub fn new(broken: Option<Broken>) -> Self {
        let mut manager = Manager::new(PARAMETERS, SILENT_SHARE, DWELL);
        manager.break_rule(broken);
        Master {
            manager,
            broken,
            rivals: Rivals::default(),
            sync: Periodic::new(PARAMETERS.producer),
            outgoing: Outgoing::default(),
            held: Vec::new(),
            unacknowledged: PerBus::default(),
            switched: None,
        }
    }

    /// Shifts the clock.
    pub fn rebase(&mut self, now: Instant) {
        let to = Rebase::new(now);
        self.manager.rebase(now);
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
            Action::Heartbeat { bus, frame } => self.outgoing.send(bus, frame, now),
            Action::Switched { from, cause, .. } => {
                self.switched = Some(cause);
                self.held.clear();
                self.outgoing.abandon(from);
                for bus in Bus::ALL {
                    self.report_health(bus, now);
                }
            }
            Action::Lost(_) | Action::Forgotten(_) | Action::Unheard(_) => {}
        }
    }

    fn report_health(&mut self, bus: Bus, now: Instant) {
        let health = if self.unacknowledged[bus] { ALONE } else { Health::default() };
        self.manager.on_health(bus, health, false, now);
    }
}

impl Station for Master {
    fn start(&mut self, now: Instant) {
        *self = Master::new(self.broken);
        for node in [PARALLEL, SELECTIVE] {
            self.manager.peers_mut().assign(node, true);
        }
        self.manager.start(now);
        let boot_up = heartbeat::encode(NodeId::MASTER, NmtState::Initialising);
        self.outgoing.send(self.manager.active(), boot_up, now);
        self.sync.restart(now);
        self.poll(now);
    }

    fn power_off(&mut self) {
        *self = Master::new(self.broken);
    }

    fn poll(&mut self, now: Instant) {
        while let Some(action) = self.manager.poll(now) {
            self.act(action, now);
        }
        while self.rivals.poll(now, PARAMETERS.quiet_time()).is_some() {}
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
        let id = frame.id();
        let node = id.node().filter(|node| *node != NodeId::MASTER);
        self.manager.on_frame(bus, node, now);
        if id == CobId::heartbeat(NodeId::MASTER) {
            self.rivals.on_heartbeat(bus, now);
        } else if let Some(node) = node
            && id == CobId::heartbeat(node)
            && let Some(state) = heartbeat::decode(frame)
            && self.manager.on_heartbeat(bus, node, state, now).start
        {
            self.send_nmt(NmtMessage { command: Command::Start, target: Target::Node(node) }, now);
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
        let sync = self.sync.deadline().filter(|_| self.manager.is_announced());
        let rivals = self.rivals.deadline(PARAMETERS.quiet_time());
        earliest(&[self.manager.deadline(), rivals, sync, self.outgoing.deadline()])
    }

    fn is_joined(&self, _bus: Bus) -> bool {
        true
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
