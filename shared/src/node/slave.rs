//! A slave node.

use super::buses::{BusNews, Buses};
use super::{BusCause, SlaveEvent, SlaveRequest, Status};
use crate::link::port::Filter;
use crate::link::{Bus, CobId, Frame};
use crate::nmt::{NmtMessage, NmtSlave, NmtState, NodeId, Reaction};
use crate::pdo::Message;
use crate::profile::Profile;
use crate::redundancy::{MasterMessage, Selection, Selector};
use crate::runner::{Filters, LinkEvent, Node, Outbox};
use crate::time::consumer::TimeConsumer;
use crate::time::{Duration, Instant, Stamp};
use crate::{heartbeat, sync};

type Out = Outbox<SlaveEvent>;

/// NMT slave, redundancy slave, SYNC and time consumer, commands and telemetry.
#[derive(Clone, Debug)]
pub struct Slave {
    id: NodeId,
    nmt: NmtSlave,
    selector: Selector,
    heartbeat: heartbeat::Producer,
    time: TimeConsumer,
    buses: Buses,
    lifetimes: Lifetimes,
}

/// How long frames may wait for their bus.
#[derive(Clone, Copy, Debug)]
struct Lifetimes {
    heartbeat: Duration,
    local_time: Duration,
    telemetry: Duration,
}

impl Slave {
    /// A slave before power-on. `id` is one of 2..=127.
    pub fn new(id: NodeId, profile: &Profile) -> Slave {
        let redundancy = profile.redundancy();
        Slave {
            id,
            nmt: NmtSlave::new(profile.autostart),
            selector: Selector::new(redundancy),
            heartbeat: heartbeat::Producer::new(id, redundancy.producer),
            time: TimeConsumer::new(id),
            buses: Buses::new(profile.access(id), profile.bus_off),
            lifetimes: Lifetimes {
                heartbeat: profile.heartbeat,
                local_time: profile.sync.min(profile.heartbeat),
                telemetry: profile.telemetry,
            },
        }
    }

    /// What it receives: exact COB-IDs only.
    pub fn filters(&self) -> Filters {
        [
            CobId::NMT,
            CobId::SYNC,
            CobId::local_time(NodeId::MASTER),
            CobId::telecommand(self.id),
            CobId::telemetry_request(self.id),
            CobId::heartbeat(NodeId::MASTER),
        ]
        .into_iter()
        .map(Filter::exact)
        .collect()
    }

    /// Boot-up on the bus selected, then Pre-operational (ECSS 8.3.2).
    fn boot(&mut self, now: Instant, out: &mut Out) {
        let frame = heartbeat::encode(self.id, NmtState::Initialising);
        out.send_for(self.selector.selected(), frame, now, self.lifetimes.heartbeat);
        out.event(SlaveEvent::State(self.nmt.boot()));
        self.heartbeat.restart(now);
        self.selector.start(now);
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, now: Instant, out: &mut Out) {
        let active = self.selector.selected();
        if self.nmt.state() == NmtState::Initialising {
            // Told again with every frame: were it lost in a full channel, the node would stay silent for ever.
            out.event(SlaveEvent::ResetNode);
            return self.buses.ignored(bus);
        }
        if !self.buses.is_joined(bus, active) {
            return self.buses.ignored(bus);
        }
        let id = frame.id();
        if id == CobId::NMT {
            return self.on_nmt(bus, frame, stamp, now, out);
        }
        if id == CobId::heartbeat(NodeId::MASTER) {
            return self.on_master_heartbeat(bus, frame, stamp, now, out);
        }
        // Only the active bus is obeyed.
        let state = self.nmt.state();
        if bus == active && id == CobId::SYNC && state.allows_sync() {
            self.on_sync(bus, frame, stamp, now, out);
        } else if bus == active && state.allows_pdo() {
            self.on_pdo(bus, frame, stamp, out);
        } else {
            self.buses.ignored(bus);
        }
    }

    fn on_nmt(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, now: Instant, out: &mut Out) {
        let Some(message) = NmtMessage::decode(frame) else { return self.buses.malformed(bus) };
        // ECSS 8.3.3g before the command itself: it decides where the answer goes.
        self.on_master(bus, MasterMessage::Command, stamp.at, now, out);
        if !message.target.includes(self.id) {
            return;
        }
        match self.nmt.on_command(message.command) {
            Reaction::Unchanged => {}
            Reaction::Entered(state) => {
                out.event(SlaveEvent::State(state));
                // The master learns of it now, not a period later.
                self.heartbeat.announce(now);
            }
            Reaction::ResetNode => {
                self.heartbeat.stop();
                out.event(SlaveEvent::ResetNode);
            }
            Reaction::ResetCommunication => self.boot(now, out),
        }
    }

    fn on_master_heartbeat(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, now: Instant, out: &mut Out) {
        if heartbeat::decode(frame).is_none() {
            return self.buses.malformed(bus);
        }
        self.on_master(bus, MasterMessage::Heartbeat, stamp.at, now, out);
        out.event(SlaveEvent::Heartbeat { bus });
    }

    fn on_master(&mut self, bus: Bus, message: MasterMessage, at: Instant, now: Instant, out: &mut Out) {
        if let Some(selection) = self.selector.on_master(bus, message, at) {
            self.apply(selection, now, out);
        }
    }

    fn on_sync(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, now: Instant, out: &mut Out) {
        if !sync::is_well_formed(frame) {
            return self.buses.malformed(bus);
        }
        if self.nmt.state().allows_pdo() {
            out.send_for(bus, self.time.on_sync(stamp), now, self.lifetimes.local_time);
        }
        out.event(SlaveEvent::Sync { bus, stamp });
    }

    fn on_pdo(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, out: &mut Out) {
        let id = frame.id();
        let event = if id == CobId::local_time(NodeId::MASTER) {
            self.time.on_spacecraft_time(frame, stamp).map(SlaveEvent::Time)
        } else if id == CobId::telecommand(self.id) {
            Message::decode(frame).map(|message| SlaveEvent::Command { bus, message })
        } else if id == CobId::telemetry_request(self.id) {
            out.show_status();
            Message::decode(frame).map(|request| SlaveEvent::TelemetryRequested { bus, request })
        } else {
            return self.buses.ignored(bus);
        };
        match event {
            Some(event) => out.event(event),
            None => self.buses.malformed(bus),
        }
    }

    fn apply(&mut self, selection: Selection, now: Instant, out: &mut Out) {
        match selection {
            Selection::Missed { bus } => {
                out.event(SlaveEvent::MasterMissed { bus });
                self.enter_pre_operational(out);
            }
            Selection::Toggled { to } => {
                self.enter_pre_operational(out);
                self.move_to(to, BusCause::Toggled, now, out);
            }
            Selection::GaveUp { bus } => out.event(SlaveEvent::GaveUp { bus }),
            Selection::Found { bus, moved: true } => self.move_to(bus, BusCause::Found, now, out),
            Selection::Found { bus, moved: false } => {
                out.event(SlaveEvent::ActiveBus { bus, cause: BusCause::Found });
            }
            Selection::Followed { to } => self.move_to(to, BusCause::Followed, now, out),
        }
    }

    fn enter_pre_operational(&mut self, out: &mut Out) {
        if let Reaction::Entered(state) = self.nmt.on_master_missed() {
            out.event(SlaveEvent::State(state));
        }
    }

    /// The heartbeat goes on on the new bus at once (ECSS 8.3.3d, h).
    fn move_to(&mut self, bus: Bus, cause: BusCause, now: Instant, out: &mut Out) {
        self.buses.change(bus.other(), bus, out);
        self.heartbeat.announce(now);
        out.event(SlaveEvent::ActiveBus { bus, cause });
    }

    /// What was due at `until`, which may be before `now`: a frame is judged as of its end.
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if self.nmt.state() == NmtState::Initialising {
            return;
        }
        while let Some(selection) = self.selector.poll(until) {
            self.apply(selection, now, out);
        }
        if let Some(frame) = self.heartbeat.poll(until, self.nmt.state()) {
            out.send_for(self.selector.selected(), frame, now, self.lifetimes.heartbeat);
        }
        while let Some(bus) = self.buses.poll(until, out) {
            out.event(SlaveEvent::BusFailed { bus });
        }
    }
}

impl Node for Slave {
    type Event = SlaveEvent;
    type Request = SlaveRequest;

    fn start(&mut self, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        self.buses.join(bus, out);
        out.event(SlaveEvent::ActiveBus { bus, cause: BusCause::PowerOn });
        self.boot(now, out);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        match self.buses.on_link(bus, event, now) {
            Some(BusNews::Health(health)) => out.event(SlaveEvent::Health { bus, health }),
            Some(BusNews::Failed(health)) => {
                out.event(SlaveEvent::Health { bus, health });
                out.event(SlaveEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => out.event(SlaveEvent::BusStalled { bus }),
            None => {}
        }
        if let LinkEvent::Received { frame, stamp } = event {
            self.run(stamp.at.min(now), now, out);
            self.on_received(bus, frame, *stamp, now, out);
        }
        self.run(now, now, out);
    }

    fn on_request(&mut self, request: SlaveRequest, now: Instant, out: &mut Out) {
        match request {
            SlaveRequest::Telemetry { bus, message } => {
                if self.nmt.state().allows_pdo() && bus == self.selector.selected() {
                    let frame = message.encode(CobId::telemetry(self.id));
                    out.send_for(bus, frame, now, self.lifetimes.telemetry);
                } else {
                    self.buses.refused(bus);
                }
            }
            SlaveRequest::ResetCounters => self.buses.counters = Default::default(),
        }
    }

    fn poll(&mut self, now: Instant, out: &mut Out) {
        self.run(now, now, out);
    }

    fn deadline(&self) -> Option<Instant> {
        if self.nmt.state() == NmtState::Initialising {
            return None;
        }
        [self.selector.deadline(), self.heartbeat.deadline(), self.buses.deadline()]
            .into_iter()
            .flatten()
            .min()
    }

    fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.time.clock().at(now),
            state: self.nmt.state(),
            active: self.selector.selected(),
            redundancy: *self.selector.parameters(),
            counters: self.buses.counters,
            health: self.buses.health,
        }
    }
}
