//! The master node.

mod boot;
mod identify;
mod objects;
mod reception;
mod transfers;

use heapless::Deque;

pub use objects::{MasterObjects, NetworkObjects};

use self::identify::Identification;
use self::transfers::Transfers;
use super::buses::{BusNews, Buses};
use super::services::Services;
use super::{Device, MasterEvent, MasterRequest, RefusalCause, Status};
use crate::boot::Boot;
use crate::link::port::{Filter, Health};
use crate::link::queue::Outgoing;
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::{BusCommand, Filters, LinkEvent, Node, Outbox};
use crate::profile::Profile;
use crate::redundancy::{Action, Manager, Parameters, Rivals};
use crate::time::LocalClock;
use crate::time::producer::TimeProducer;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, Scet};
use crate::{heartbeat, sync};

type Out = Outbox<MasterEvent>;

/// A spacecraft time that waited longer on its way out would set clocks late by that much.
const TIME_LIFETIME: Duration = Duration::from_millis(5);

/// Frames that may wait until the active bus is announced.
const HELD: usize = 16;

/// NMT master, redundancy master, SYNC and time producer, SDO client, CANopen device; commands and telemetry.
#[derive(Debug)]
pub struct Master<D: Device> {
    redundancy: Parameters,
    services: Services<MasterObjects<D>>,
    boot: Boot,
    transfers: Transfers,
    /// The device has something to do before its deadline.
    is_device_due: bool,
    manager: Manager,
    rivals: Rivals,
    identification: Identification,
    sync: sync::Producer,
    time: TimeProducer,
    clock: LocalClock,
    buses: Buses,
    lifetimes: Lifetimes,
    /// COB-IDs of [`Profile::stamped`].
    stamped: &'static [CobId],
    held: Deque<Outgoing, HELD>,
    /// Spacecraft time when the last SYNC was sent.
    at_sync: Option<Scet>,
}

/// How long frames may wait for their bus.
#[derive(Clone, Copy, Debug)]
struct Lifetimes {
    heartbeat: Duration,
    sync: Duration,
    time: Duration,
    command: Duration,
    telemetry: Duration,
    sdo: Duration,
}

impl<D: Device> Master<D> {
    /// A master before power-on.
    pub fn new(profile: &Profile, device: D) -> Self {
        let redundancy = profile.redundancy();
        let objects = objects::at_power_on(profile, device);
        let sync = objects::sync_config(&objects.communication);
        let mut master = Master {
            redundancy,
            services: Services::new(NodeId::MASTER, objects, profile.sdo_timeout),
            boot: boot::at_power_on(profile),
            transfers: Transfers::new(profile.sdo_timeout, profile.network.bit_rate),
            is_device_due: false,
            manager: Manager::new(redundancy, profile.silent_share, profile.dwell),
            rivals: Rivals::default(),
            identification: Identification::default(),
            sync: sync::Producer::with(sync),
            time: TimeProducer::new(profile.time),
            clock: LocalClock::default(),
            buses: Buses::new(profile.access(NodeId::MASTER), profile.bus_off),
            lifetimes: Lifetimes {
                heartbeat: profile.heartbeat,
                sync: profile.sync.min(profile.heartbeat),
                time: TIME_LIFETIME,
                command: profile.command,
                telemetry: profile.telemetry,
                sdo: profile.sdo_timeout,
            },
            stamped: profile.stamped,
            held: Deque::new(),
            at_sync: None,
        };
        for slave in profile.slaves {
            master.manager.peers_mut().assign(slave.node, slave.assignment().is_slave());
        }
        master
    }

    /// What it receives: heartbeats, telemetry, local times and SDO responses of all slaves, EMCY and foreign SYNCs,
    /// requests to its own SDO server.
    pub fn filters(&self) -> Filters {
        let node = NodeId::MASTER;
        let functions = [
            CobId::heartbeat(node),
            CobId::telemetry(node),
            CobId::local_time(node),
            CobId::sdo_response(node),
            CobId::SYNC,
        ];
        let server = Filter::exact(CobId::sdo_request(node));
        functions.into_iter().map(Filter::function).chain([server]).collect()
    }

    fn send_nmt(&mut self, message: NmtMessage, now: Instant, out: &mut Out) -> bool {
        self.send(message.encode(), now, self.lifetimes.heartbeat, out)
    }

    /// To the active bus, when it is announced. Whether there was room to wait for that.
    fn send(&mut self, frame: Frame, now: Instant, lifetime: Duration, out: &mut Out) -> bool {
        let bus = self.manager.active();
        if self.manager.is_announced() {
            out.send_for(bus, frame, now, lifetime);
            return true;
        }
        let taken = self.held.push_back(Outgoing { frame, expires: now + lifetime }).is_ok();
        if !taken {
            self.buses.refused(bus);
        }
        taken
    }

    fn release_held(&mut self, now: Instant, out: &mut Out) {
        let bus = self.manager.active();
        while self.manager.is_announced() {
            let Some(outgoing) = self.held.pop_front() else { return };
            if outgoing.is_expired(now) {
                self.buses.expired(bus);
            } else {
                out.command(bus, BusCommand::Send(outgoing));
            }
        }
    }

    fn on_health(&mut self, bus: Bus, health: Health, now: Instant, out: &mut Out) {
        self.manager.on_health(bus, health, self.buses.is_failed(bus), now);
        self.services.on_health(bus, &health);
        self.refresh_health();
        self.is_device_due = true;
        out.event(MasterEvent::Health { bus, health });
    }

    fn on_message(&mut self, node: NodeId, frame: Frame, lifetime: Duration, now: Instant, out: &mut Out) {
        let cause = if self.manager.peers().state(node) != Some(NmtState::Operational) {
            self.buses.refused(self.manager.active());
            RefusalCause::NotOperational
        } else if !self.send(frame, now, lifetime, out) {
            RefusalCause::Busy
        } else {
            return;
        };
        out.event(MasterEvent::Refused { node, cause });
    }

    fn on_nmt_request(&mut self, message: NmtMessage, now: Instant, out: &mut Out) {
        let held = matches!(message.command, Command::Stop | Command::EnterPreOperational);
        self.manager.peers_mut().hold(message.target, held);
        if held {
            self.boot.on_commanded(message.target);
        }
        if !self.send_nmt(message, now, out)
            && let Target::Node(node) = message.target
        {
            out.event(MasterEvent::Refused { node, cause: RefusalCause::Busy });
        }
    }

    fn act(&mut self, action: Action, now: Instant, out: &mut Out) {
        match action {
            Action::Heartbeat { bus, frame } => out.send_for(bus, frame, now, self.lifetimes.heartbeat),
            Action::Switched { from, to, cause } => {
                // What waited for the bus that is left never goes out.
                while self.held.pop_front().is_some() {
                    self.buses.left(from);
                }
                self.buses.change(from, to, out);
                // With selective access nothing is known any more of the bus left, and nothing yet of the new one.
                for bus in [from, to] {
                    self.manager.on_health(bus, self.buses.health[bus], self.buses.is_failed(bus), now);
                }
                out.event(MasterEvent::BusSwitched { from, to, cause });
                self.on_bus_changed(now, out);
            }
            Action::Lost(node) => {
                self.show_state(node, objects::MISSING);
                self.boot.on_lost(node);
                out.event(MasterEvent::SlaveLost { node });
            }
            Action::Forgotten(node) => self.show_state(node, objects::UNKNOWN),
            Action::Unheard(node) => {
                self.show_state(node, objects::MISSING);
                out.event(MasterEvent::SlaveUnheard { node });
            }
        }
    }

    /// What was due at `until`, which may be before `now`: a frame is judged as of its end.
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        while let Some(bus) = self.buses.poll(until, out) {
            self.manager.on_health(bus, self.buses.health[bus], true, now);
            out.event(MasterEvent::BusFailed { bus });
        }
        while let Some(action) = self.manager.poll(until) {
            self.act(action, now, out);
        }
        self.run_rivals(until, out);
        self.release_held(now, out);
        self.run_boot(until, now, out);
        self.run_device(until, now, out);
        if self.manager.is_announced() {
            let bus = self.manager.active();
            if self.boot.is_released()
                && let Some(frame) = self.sync.poll(until)
            {
                out.send_for(bus, frame, now, self.lifetimes.sync);
            }
            if let Some(frame) = self.time.poll(now, &self.clock) {
                out.send_for(bus, frame, now, self.lifetimes.time);
            }
        }
    }

    /// The node as it is at `now`.
    pub fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.clock.at(now),
            state: NmtState::Operational,
            active: self.manager.active(),
            redundancy: self.redundancy,
            counters: self.buses.counters,
            health: self.buses.health,
        }
    }
}

impl<D: Device> Node for Master<D> {
    type Event = MasterEvent;
    type Request = MasterRequest;

    fn filters(&self) -> Filters {
        self.filters()
    }

    fn start(&mut self, now: Instant, out: &mut Out) {
        let bus = self.manager.active();
        self.buses.join(bus, out);
        let boot_up = heartbeat::encode(NodeId::MASTER, NmtState::Initialising);
        out.send_for(bus, boot_up, now, self.lifetimes.heartbeat);
        self.manager.start(now);
        self.services.configure(now);
        self.boot.start(now);
        self.sync.start(now);
        self.time.start(now);
        self.run(now, now, out);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        match self.buses.on_link(bus, event, now) {
            Some(BusNews::Health(health)) => self.on_health(bus, health, now, out),
            Some(BusNews::Failed(health)) => {
                self.on_health(bus, health, now, out);
                out.event(MasterEvent::BusFailed { bus });
            }
            Some(BusNews::Stalled) => out.event(MasterEvent::BusStalled { bus }),
            None => {}
        }
        match event {
            LinkEvent::Received { frame, stamp } => {
                self.run(stamp.at.min(now), now, out);
                self.on_received(bus, frame, *stamp, now, out);
            }
            LinkEvent::Transmitted { frame, stamp } => {
                self.on_transmitted(bus, frame, *stamp, out);
                self.on_sdo_sent(bus, frame);
            }
            LinkEvent::Failed { frame, cause } => {
                self.on_failed(bus, frame, *cause);
                self.on_sdo_sent(bus, frame);
            }
            LinkEvent::Unsent { frames } => self.on_unsent(bus, *frames),
            LinkEvent::Overrun { .. } => self.lost(bus),
            LinkEvent::Counters(_) => self.refresh_health(),
            LinkEvent::Health(_) | LinkEvent::Stalled => {}
        }
        self.run(now, now, out);
    }

    fn on_request(&mut self, request: MasterRequest, now: Instant, out: &mut Out) {
        match request {
            MasterRequest::Command { node, message } => {
                let frame = message.encode(CobId::telecommand(node));
                self.on_message(node, frame, self.lifetimes.command, now, out);
            }
            MasterRequest::RequestTelemetry { node, message } => {
                let frame = message.encode(CobId::telemetry_request(node));
                self.on_message(node, frame, self.lifetimes.telemetry, now, out);
            }
            MasterRequest::SwitchBus(bus) => self.manager.request(bus),
            MasterRequest::Nmt(message) => self.on_nmt_request(message, now, out),
            MasterRequest::Boot(node) => self.boot.queue(node),
            MasterRequest::SetTime(scet) => self.clock.set(scet, now),
        }
        self.run(now, now, out);
    }

    fn poll(&mut self, now: Instant, out: &mut Out) {
        self.run(now, now, out);
    }

    fn deadline(&self) -> Option<Instant> {
        let gated = self
            .manager
            .is_announced()
            .then(|| [self.sync.deadline().filter(|_| self.boot.is_released()), self.time.deadline()]);
        let always = [
            self.manager.deadline(),
            self.buses.deadline(),
            self.boot.deadline(),
            self.transfers.deadline(),
            self.identification_deadline(),
            self.rivals.deadline(self.redundancy.quiet_time()),
            self.device_deadline(),
        ];
        always.into_iter().chain(gated.into_iter().flatten()).flatten().min()
    }

    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool {
        bus == self.manager.active()
            && self.stamped.contains(&frame.id())
            && (frame.id() != self.sync.id() || sync::is_sync_length(frame))
    }
}
