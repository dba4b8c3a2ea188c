//! A world of the host: the nodes' own code on mocks of ports and clocks.

use std::rc::Rc;

use can_wire::fault::Fault;
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::types::{Bus, NodeId, PerBus};
use host_worlds::World;
use host_worlds::log::Happening;

use crate::broken::Rule;
use crate::craft::{self, CampaignSlave, Notes};
use crate::scene::{News, Noted, Reading, Scene, Sent};
use crate::script::Script;

/// The world of a run.
pub struct Host {
    world: World,
    script: Script,
    notes: Rc<Notes>,
    entries: usize,
    frames: PerBus<usize>,
    deeds: usize,
    /// Value of the last command that each node executed.
    last: [u32; 128],
}

impl Host {
    /// The spacecraft of a script; `broken`: a rule that does not hold.
    pub fn new(script: &Script, broken: Option<Rule>) -> Host {
        let (world, notes) = craft::world(script, broken);
        Host {
            world,
            script: script.clone(),
            notes,
            entries: 0,
            frames: PerBus::default(),
            deeds: 0,
            last: [0; 128],
        }
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
        let noted = |news, entry: &host_worlds::log::Entry| Noted { at: entry.at, node: entry.node, news };
        new.iter().filter_map(|entry| Some(noted(news(&entry.what)?, entry))).collect()
    }

    fn take_frames(&mut self) -> PerBus<Vec<Sent>> {
        PerBus::from_fn(|bus| {
            let frames = self.world.frames(bus);
            let new = &frames[std::mem::replace(&mut self.frames[bus], frames.len())..];
            let sent = |sent: &Rc<host_worlds::world::Sent>| Sent {
                start: sent.start,
                end: sent.end,
                node: sent.node,
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
            let scet = self.world.slave(node).with(|slave: &mut CampaignSlave, now| slave.scet(now));
            Reading { at, node, scet }
        };
        powered.map(read).collect()
    }

    /// Each command is executed once, in its order, and none that is older than its lifetime.
    fn take_wrongs(&mut self) -> Vec<String> {
        let mut wrongs = Vec::new();
        let deeds = self.notes.deeds.borrow();
        let clock = self.world.clock(NodeId::MASTER);
        let lifetime = craft::lifetime(&self.script);
        for deed in &deeds[std::mem::replace(&mut self.deeds, deeds.len())..] {
            let (node, at) = (deed.node.get(), deed.at.as_us());
            let last = std::mem::replace(&mut self.last[usize::from(node)], deed.value);
            if deed.value <= last {
                wrongs.push(format!("slave {node} executed command {} after {last}, {at} us", deed.value));
            }
            let made = self.notes.made(deed.value).zip(clock.as_ref());
            let made = made.map(|(made, clock)| clock.world_time(made));
            if let Some(made) = made.filter(|made| deed.at > *made + lifetime) {
                let age = deed.at.since(made).as_us();
                wrongs.push(format!("slave {node} executed a command {age} us old, {at} us"));
            }
        }
        wrongs
    }

    fn unconfigured(&self) -> Vec<NodeId> {
        let powered = self.world.slaves().into_iter().filter(|node| self.world.is_powered(*node));
        let lacks = |node: &NodeId| {
            self.world.slave(*node).with(|slave: &mut CampaignSlave, _| !craft::is_configured(slave))
        };
        powered.filter(|node| craft::is_assigned(&self.script, *node)).filter(lacks).collect()
    }

    fn bdefault(&self, node: NodeId) -> Option<Bus> {
        self.world.is_powered(node).then(|| self.world.status(node).redundancy.bdefault)
    }

    fn disturbance(&self, bus: Bus) -> u64 {
        let counters = self.world.counters(bus);
        counters.destroyed + counters.ack_errors
    }

    fn is_busy(&self, bus: Bus) -> bool {
        self.world.is_busy(bus)
    }

    fn is_powered(&self, node: NodeId) -> bool {
        self.world.is_powered(node)
    }

    fn power(&mut self, node: NodeId, on: bool) {
        if on { self.world.power_on(node) } else { self.world.power_off(node) }
    }

    fn reset(&mut self, node: NodeId) {
        self.world.reset(node);
    }

    fn nodes(&self) -> usize {
        self.world.slaves().len() + 1
    }

    fn index(&self, node: NodeId) -> usize {
        self.world.index(node)
    }

    fn strike(&mut self, bus: Bus, fault: Fault) {
        self.world.strike(bus, fault);
    }

    fn inject(&mut self, bus: Bus, frame: WireFrame) {
        self.world.inject(bus, frame);
    }
}

/// An entry of the log; `None` for what is no change of state.
fn news(what: &Happening) -> Option<News> {
    Some(match *what {
        Happening::PowerOn => News::PowerOn,
        Happening::PowerOff => News::PowerOff,
        Happening::Master(event) => match event {
            MasterEvent::BusSwitched { from, to, cause } => News::Switched { from, to, cause },
            MasterEvent::SecondMaster { .. } => News::Collision,
            MasterEvent::Pdo { .. }
            | MasterEvent::Frame { .. }
            | MasterEvent::Synchronised { .. }
            | MasterEvent::Time(_)
            | MasterEvent::Step(_)
            | MasterEvent::Written(_)
            | MasterEvent::SyncSent { .. } => return None,
            _ => News::Other,
        },
        Happening::Slave(event) => match event {
            SlaveEvent::State(state) => News::State(state),
            SlaveEvent::ActiveBus { bus, .. } => News::ActiveBus(bus),
            SlaveEvent::Step(_) => News::ClockSet,
            SlaveEvent::Clash { .. } => News::Collision,
            SlaveEvent::Pdo { .. }
            | SlaveEvent::Synchronised { .. }
            | SlaveEvent::Heartbeat { .. }
            | SlaveEvent::Sync { .. }
            | SlaveEvent::Time(_)
            | SlaveEvent::Written(_) => return None,
            _ => News::Other,
        },
    })
}
