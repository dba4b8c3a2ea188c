//! A world of the host: the nodes' own code on mocks of ports and clocks.

use std::collections::BTreeMap;
use std::rc::Rc;

use can_twin::wire::fault::Fault;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can::emcy::{ActiveError, ErrorRegister};
use ecss_can::link::port::ErrorState;
use ecss_can::node::{Master, MasterEvent, SlaveEvent};
use ecss_can::redundancy::{MasterBoards, OneBoard, Parameters, Role, TwoBoards};
use ecss_can::runner::extend::WholeNode;
use ecss_can::types::{Bus, NodeId, PerBus};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::{NodeKey, World};
use mission::CommanderObjects;
use mission::application::slave;

use crate::campaign::application::Errors;
use crate::campaign::nodes;
use crate::campaign::notes::{self, Notes};
use crate::campaign::rule::Rule;
use crate::campaign::scene::{News, Noted, Reading, Scene, Sent};
use crate::campaign::script::Script;

/// The world of a run.
pub struct Host {
    world: World,
    script: Script,
    notes: Rc<Notes>,
    entries: usize,
    frames: PerBus<usize>,
    executions: usize,
    /// Value of the last command that each node executed, by life of the master: two masters may both be active for a
    /// while.
    last: BTreeMap<(NodeId, u32), u32>,
}

impl Host {
    /// Makes the spacecraft of a script. `broken`: a rule that is broken.
    pub fn new(script: &Script, broken: Option<Rule>) -> Host {
        let (world, notes) = nodes::world(script, broken);
        Host {
            world,
            script: script.clone(),
            notes,
            entries: 0,
            frames: PerBus::default(),
            executions: 0,
            last: BTreeMap::new(),
        }
    }
}

impl Host {
    fn known_errors<B: MasterBoards>(&self, master: NodeKey) -> Vec<ActiveError> {
        let master = self.world.node::<Master<CommanderObjects, B>>(master);
        master.with(|master, _| master.active_errors().collect())
    }

    /// Returns the difference between the errors of a slave and those that a master knows.
    fn unknown_to(&self, known: &[ActiveError], node: NodeId) -> Option<String> {
        let register = self
            .world
            .slave(node)
            .with(|slave: &mut slave::Node, _| slave.objects().communication.emcy.register);
        let known: Vec<&ActiveError> = known.iter().filter(|error| error.node == node).collect();
        let explained =
            known.iter().fold(ErrorRegister::default(), |all, error| all.and(ErrorRegister::of(error.code)));
        let error = ActiveError { node, code: Errors::ERROR.code, source: Errors::ERROR.source };
        let is_there = self.notes.errors.borrow().get(&node) == Some(&true);
        let is_known = known.contains(&&error) == is_there && explained.bits() == register;
        (!is_known).then(|| {
            format!(
                "its error is {}, 1001h is {register:02X}h, the master knows {known:?}",
                if is_there { "active" } else { "over" }
            )
        })
    }
}

impl Scene for Host {
    fn now(&self) -> Time {
        self.world.now()
    }

    fn run_until(&mut self, end: Time) {
        self.world.run_until(end);
    }

    fn take_news(&mut self) -> Vec<Noted> {
        let log = self.world.log();
        let new = &log[std::mem::replace(&mut self.entries, log.len())..];
        let mut takeovers = self.notes.takeovers.borrow_mut();
        let noted = |entry: &ecss_can_worlds::log::Entry| {
            let news = match entry.what {
                NodeEvent::Master(MasterEvent::Role(change)) => {
                    let is_active = change.role == Role::Active;
                    News::Role(if is_active { takeovers.pop_front() } else { None })
                }
                what => news(&what)?,
            };
            Some(Noted { at: entry.at, key: entry.key, news })
        };
        new.iter().filter_map(noted).collect()
    }

    fn take_frames(&mut self) -> PerBus<Vec<Sent>> {
        PerBus::from_fn(|bus| {
            let frames = self.world.frames(bus);
            let new = &frames[std::mem::replace(&mut self.frames[bus], frames.len())..];
            let sent = |sent: &Rc<ecss_can_worlds::world::Sent>| Sent {
                start: sent.start,
                end: sent.end,
                key: sent.key,
                id: sent.id(),
                receivers: sent.receivers,
            };
            new.iter().map(sent).collect()
        })
    }

    fn take_clocks(&mut self) -> Vec<Reading> {
        let at = self.world.now();
        let powered = self.world.slaves().into_iter().filter(|node| self.world.is_powered(*node));
        let read = |node| {
            let scet = self.world.slave(node).with(|slave: &mut slave::Node, now| slave.scet(now));
            Reading { at, node, scet }
        };
        powered.map(read).collect()
    }

    /// Returns violations of: each command is executed once, in order, and none is older than its lifetime.
    fn take_wrongs(&mut self) -> Vec<String> {
        let mut wrongs = Vec::new();
        let executions = self.notes.executions.borrow();
        let lifetime = nodes::lifetime(&self.script);
        for execution in &executions[std::mem::replace(&mut self.executions, executions.len())..] {
            let (node, at) = (execution.node.get(), execution.at.as_us());
            let life = if self.script.masters == 1 { 0 } else { notes::life(execution.value) };
            let last = self.last.insert((execution.node, life), execution.value).unwrap_or(0);
            if execution.value <= last {
                wrongs
                    .push(format!("slave {node} executed command {} after {last}, {at} us", execution.value));
            }
            let made = self.notes.made(execution.value);
            let made = made.and_then(|(key, made)| Some(self.world.clock(key)?.world_time(made)));
            if let Some(made) = made.filter(|made| execution.at > *made + lifetime) {
                let age = execution.at.since(made).as_us();
                wrongs.push(format!("slave {node} executed a command {age} us old, {at} us"));
            }
        }
        wrongs
    }

    fn unconfigured(&self) -> Vec<NodeId> {
        let powered = self.world.slaves().into_iter().filter(|node| self.world.is_powered(*node));
        let lacks = |node: &NodeId| {
            self.world.slave(*node).with(|slave: &mut slave::Node, _| !nodes::is_configured(slave))
        };
        powered.filter(|node| nodes::is_assigned(&self.script, *node)).filter(lacks).collect()
    }

    fn unknown_errors(&self) -> Vec<(NodeId, NodeKey, String)> {
        let mut all = Vec::new();
        for master in self.world.active_masters() {
            let known = if self.script.masters == 1 {
                self.known_errors::<OneBoard>(master)
            } else {
                self.known_errors::<TwoBoards>(master)
            };
            for slave in self.world.slaves().into_iter().filter(|node| self.world.is_powered(*node)) {
                all.extend(self.unknown_to(&known, slave).map(|what| (slave, master, what)));
            }
        }
        all
    }

    fn parameters(&self, node: NodeId) -> Option<Parameters> {
        self.world.is_powered(node).then(|| self.world.status(node).redundancy)
    }

    fn disturbance(&self, bus: Bus) -> u64 {
        let counters = self.world.counters(bus);
        counters.destroyed + counters.ack_errors
    }

    fn is_busy(&self, bus: Bus) -> bool {
        self.world.is_busy(bus)
    }

    fn is_powered(&self, key: NodeKey) -> bool {
        self.world.is_powered(key)
    }

    fn power(&mut self, key: NodeKey, on: bool) {
        if on { self.world.power_on(key) } else { self.world.power_off(key) }
    }

    fn reset(&mut self, key: NodeKey) {
        self.world.reset(key);
    }

    fn nodes(&self) -> usize {
        self.world.slaves().len() + usize::from(self.script.masters)
    }

    fn index(&self, key: NodeKey) -> usize {
        self.world.index(key)
    }

    fn strike(&mut self, bus: Bus, fault: Fault) {
        self.world.strike(bus, fault);
    }

    fn inject(&mut self, bus: Bus, frame: WireFrame) {
        self.world.inject(bus, frame);
    }
}

/// Converts an entry of the log; `None` if it is not a change of state.
fn news(what: &NodeEvent) -> Option<News> {
    Some(match *what {
        NodeEvent::PowerOn => News::PowerOn,
        NodeEvent::PowerOff => News::PowerOff,
        NodeEvent::Master(event) => match event {
            MasterEvent::BusSwitched { from, to, cause } => News::Switched { from, to, cause },
            MasterEvent::SecondMaster { .. } => News::Collision,
            MasterEvent::Health { bus, health } => {
                News::Hearing { bus, is_on: health.state != ErrorState::BusOff }
            }
            MasterEvent::Pdo(_)
            | MasterEvent::Frame { .. }
            | MasterEvent::Synchronised(_)
            | MasterEvent::Time(_)
            | MasterEvent::Step(_)
            | MasterEvent::Written(_)
            | MasterEvent::ErrorsRead { .. }
            | MasterEvent::NotSent { .. }
            | MasterEvent::SyncSent { .. } => return None,
            _ => News::Other,
        },
        NodeEvent::Slave(event) => match event {
            SlaveEvent::State(state) => News::State(state),
            SlaveEvent::ActiveBus { bus, .. } => News::ActiveBus(bus),
            SlaveEvent::Step(_) => News::ClockSet,
            SlaveEvent::Clash { .. } => News::Collision,
            SlaveEvent::Pdo(_)
            | SlaveEvent::Synchronised(_)
            | SlaveEvent::Heartbeat { .. }
            | SlaveEvent::Sync { .. }
            | SlaveEvent::Time(_)
            | SlaveEvent::NotSent { .. }
            | SlaveEvent::Written(_) => return None,
            _ => News::Other,
        },
        // There is no minimal slave in the campaign.
        NodeEvent::Minimal(_) => return None,
    })
}
