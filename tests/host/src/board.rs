//! One node with its power switch: two mock ports, a clock, and the tasks of the boards' firmware.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::{Arc, Mutex};

use ecss_can::node::Node;
use ecss_can::profile::Profile;
use ecss_can::runner::{Events, Handle, Platform, Resources, Runners, Telltale};
use ecss_can::store::RetainedMemory;
use ecss_can::types::{Bus, NodeId, PerBus};
use futures_executor::{LocalPool, LocalSpawner};
use futures_util::task::LocalSpawnExt;
use mission::COMMAND_PERIOD;

use crate::application::{self, Diary, MasterHandle, Sequences, SlaveHandle};
use crate::clock::MockClock;
use crate::log::{Entry, Happening};
use crate::port::MockPort;
use crate::timeline::Timeline;

/// A board of the host: controllers on simulated wires, and a clock of its own.
pub struct Mock;

impl Platform for Mock {
    type Port = MockPort;
    type Clock = MockClock;
}

/// Bytes of a slave's data store.
const STORE: usize = 24 * 1024;

/// RAM that outlives a reset, and holds anything after power-on.
#[derive(Clone)]
struct Ram(Arc<Mutex<[u32; 2]>>);

impl Ram {
    fn of_power_on() -> Ram {
        Ram(Arc::new(Mutex::new([0x5A5A_0F0F, 0x0FF0_1234])))
    }
}

impl RetainedMemory for Ram {
    fn read(&self) -> [u32; 2] {
        *self.0.lock().expect("one thread")
    }

    fn write(&mut self, words: [u32; 2]) {
        *self.0.lock().expect("one thread") = words;
    }
}

/// What a node is, with or without power.
pub(crate) struct Board {
    pub id: NodeId,
    drift_ppm: i32,
    profile: Profile,
    /// Slaves that the master's application keeps busy.
    traffic: Vec<NodeId>,
    diary: Diary,
    ports: PerBus<MockPort>,
    ram: Ram,
    powered: Option<Powered>,
}

/// What lives from power-on to power-off or reset.
struct Powered {
    pool: LocalPool,
    clock: MockClock,
    telltale: &'static Telltale,
    master: Option<(MasterHandle, Rc<Sequences>)>,
    slave: Option<SlaveHandle>,
    reset: Rc<Cell<bool>>,
}

impl Board {
    pub fn new(
        id: NodeId,
        drift_ppm: i32,
        profile: Profile,
        traffic: Vec<NodeId>,
        timeline: Rc<Timeline>,
        entries: Rc<RefCell<Vec<Entry>>>,
    ) -> Self {
        let diary = Diary { node: id, timeline, entries };
        let clock = MockClock::power_on(diary.timeline.clone(), drift_ppm);
        let ports = PerBus::from_fn(|_| MockPort::new(clock.clone()));
        Board { id, drift_ppm, profile, traffic, diary, ports, ram: Ram::of_power_on(), powered: None }
    }

    pub fn power_on(&mut self) {
        self.diary.note(Happening::PowerOn);
        let pool = LocalPool::new();
        let clock = MockClock::power_on(self.diary.timeline.clone(), self.drift_ppm);
        Bus::ALL.into_iter().for_each(|bus| self.ports[bus].reset(clock.clone()));
        let telltale = Box::leak(Box::default());
        let reset = Rc::new(Cell::new(false));
        let shell = Shell { spawner: pool.spawner(), clock: &clock, ports: &self.ports, telltale };
        let (mut master, mut slave) = (None, None);
        if self.id == NodeId::MASTER {
            let (handle, events) = shell.run(mission::master(&self.profile, None));
            shell.spawn(application::master(events, self.diary.clone()));
            let slaves = self.traffic.clone();
            let sequences = Rc::new(Sequences::new(clock.clone(), COMMAND_PERIOD));
            shell.spawn(application::traffic(handle, slaves, sequences.clone()));
            master = Some((handle, sequences));
        } else {
            let node = mission::slave(self.id, &self.profile, vec![0; STORE])
                .with_retained(Box::leak(Box::new(self.ram.clone())));
            let (handle, events) = shell.run(node);
            slave = Some(handle);
            let diary = self.diary.clone();
            shell.spawn(application::slave(handle, events, diary, reset.clone()));
        }
        self.powered = Some(Powered { pool, clock, telltale, master, slave, reset });
    }

    pub fn power_off(&mut self) {
        if let Some(powered) = self.powered.take() {
            Bus::ALL.into_iter().for_each(|bus| self.ports[bus].reset(powered.clock.clone()));
            self.ram = Ram::of_power_on();
            self.diary.note(Happening::PowerOff);
        }
    }

    pub fn is_powered(&self) -> bool {
        self.powered.is_some()
    }

    /// Lets every task do what it can now.
    pub fn run(&mut self) {
        while let Some(powered) = &mut self.powered {
            powered.pool.run_until_stalled();
            if !powered.reset.get() {
                return;
            }
            self.power_on();
        }
    }

    /// The controller on a bus.
    pub fn port(&self, bus: Bus) -> &MockPort {
        &self.ports[bus]
    }

    pub fn clock(&self) -> Option<&MockClock> {
        Some(&self.powered.as_ref()?.clock)
    }

    pub fn telltale(&self) -> Option<&'static Telltale> {
        Some(self.powered.as_ref()?.telltale)
    }

    /// The node of a master that has power.
    pub fn master(&self) -> Option<MasterHandle> {
        Some(self.powered.as_ref()?.master.as_ref()?.0)
    }

    /// The numbers of the commands of a master that has power.
    pub fn sequences(&self) -> Option<Rc<Sequences>> {
        Some(self.powered.as_ref()?.master.as_ref()?.1.clone())
    }

    /// The node of a slave that has power.
    pub fn slave(&self) -> Option<SlaveHandle> {
        self.powered.as_ref()?.slave
    }

    /// A task more, until it ends or the node loses its power.
    pub fn spawn(&self, task: impl Future<Output = ()> + 'static) {
        let powered = self.powered.as_ref().expect("it has power");
        powered.pool.spawner().spawn_local(task).expect("the pool of this board lives");
    }
}

/// Spawns what `main` of an image spawns.
struct Shell<'a> {
    spawner: LocalSpawner,
    clock: &'a MockClock,
    ports: &'a PerBus<MockPort>,
    telltale: &'static Telltale,
}

impl Shell<'_> {
    /// A power-on needs new memory: handles to the old node may still be in use.
    fn run<N: Node + 'static>(&self, node: N) -> (Handle<Mock, N>, Events<Mock, N>) {
        let resources: &Resources<Mock, N> = Box::leak(Box::default());
        let (ports, clock) = (self.ports.clone(), self.clock.clone());
        let (handle, events, runners) = resources.start(|| node, ports, clock, self.telltale);
        let Runners { nominal, redundant, due } = runners;
        self.spawn(async { nominal.run().await });
        self.spawn(async { redundant.run().await });
        self.spawn(async { due.run().await });
        (handle, events)
    }

    fn spawn(&self, task: impl Future<Output = ()> + 'static) {
        self.spawner.spawn_local(task).expect("the pool of this board lives");
    }
}
