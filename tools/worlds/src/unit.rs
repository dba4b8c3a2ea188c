//! One node with its power switch: two mock ports, a clock, memory, and the tasks of the boards' firmware.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use can_twin::wire::time::Time;
use ecss_can::node::Hardware;
use ecss_can::runner::{Connection, Diagnostics, Resources, Runners};
use ecss_can::types::{Bus, PerBus};

use crate::board::MockBoard;
use crate::clock::MockClock;
use crate::key::NodeKey;
use crate::log::{Entry, NodeEvent};
use crate::member::{Diary, Events, Handle, Member, Running};
use crate::memory::{Flash, Ram};
use crate::pool::{Pool, Spawner};
use crate::port::{BoardPort, Missed, MockPort, one_controller};
use crate::timeline::Timeline;

/// Code of `main` of an image, called once per power-on: makes the node, spawns its application.
pub(crate) type Firmware = Rc<dyn Fn(MockBoard, &Shell<'_>) -> Box<dyn Running>>;

/// Firmware of a node and its application.
pub(crate) fn firmware<N: Member, A: Future<Output = ()> + 'static>(
    node: impl Fn(MockBoard) -> N + 'static,
    application: impl Fn(Handle<N>, Events<N>) -> A + 'static,
) -> Firmware {
    Rc::new(move |board, shell| {
        let (handle, events) = shell.run(|| node(board));
        shell.spawn(application(handle, events));
        Box::new(handle)
    })
}

/// A node before its world is built.
pub(crate) struct Planned {
    pub key: NodeKey,
    pub firmware: Firmware,
    pub drift_ppm: i32,
    pub has_one_controller: bool,
    pub power_on: Time,
    pub late_heartbeats: u32,
    pub missed: Missed,
}

/// A node, with or without power.
pub(crate) struct Unit {
    pub key: NodeKey,
    firmware: Firmware,
    drift_ppm: i32,
    has_one_controller: bool,
    late_heartbeats: u32,
    diary: Diary,
    ports: PerBus<MockPort>,
    ram: Ram,
    flash: Flash,
    powered: Option<Powered>,
}

/// State from power-on to power-off or reset.
struct Powered {
    pool: Pool,
    clock: MockClock,
    diagnostics: &'static Diagnostics,
    node: Box<dyn Running>,
    reset: Rc<Cell<bool>>,
}

impl Unit {
    pub fn new(
        planned: Planned,
        timeline: Rc<Timeline>,
        entries: Rc<RefCell<Vec<Entry>>>,
        changed: &PerBus<Rc<Cell<bool>>>,
    ) -> Self {
        let Planned { key, firmware, drift_ppm, has_one_controller, late_heartbeats, missed, .. } = planned;
        let diary = Diary { key, timeline, entries };
        let clock = MockClock::power_on(diary.timeline.clone(), drift_ppm);
        let ports = PerBus::from_fn(|bus| MockPort::that_sets(clock.clone(), changed[bus].clone()));
        Bus::ALL.into_iter().for_each(|bus| ports[bus].set_missed(missed.clone()));
        let (ram, flash) = (Ram::of_power_on(), Flash::default());
        Unit {
            key,
            firmware,
            drift_ppm,
            has_one_controller,
            late_heartbeats,
            diary,
            ports,
            ram,
            flash,
            powered: None,
        }
    }

    pub fn power_on(&mut self) {
        self.diary.note(NodeEvent::PowerOn);
        let pool = Pool::new();
        let clock = MockClock::power_on(self.diary.timeline.clone(), self.drift_ppm);
        Bus::ALL.into_iter().for_each(|bus| self.ports[bus].reset(clock.clone()));
        let diagnostics = Box::leak(Box::default());
        let reset = Rc::new(Cell::new(false));
        let shell = Shell {
            spawner: pool.spawner(),
            clock: &clock,
            ports: &self.ports,
            has_one_controller: self.has_one_controller,
            diagnostics,
            diary: &self.diary,
            reset: &reset,
        };
        let mut hardware = Hardware::default();
        hardware.late_heartbeats = self.late_heartbeats;
        hardware.retained = Some(Box::leak(Box::new(self.ram.clone())));
        hardware.store = Some(Box::leak(Box::new(self.flash.clone())));
        let board = MockBoard { node_id: self.key.node(), hardware };
        let node = (self.firmware)(board, &shell);
        self.powered = Some(Powered { pool, clock, diagnostics, node, reset });
    }

    pub fn power_off(&mut self) {
        if let Some(powered) = self.powered.take() {
            Bus::ALL.into_iter().for_each(|bus| self.ports[bus].reset(powered.clock.clone()));
            self.ram = Ram::of_power_on();
            self.diary.note(NodeEvent::PowerOff);
        }
    }

    pub fn is_powered(&self) -> bool {
        self.powered.is_some()
    }

    /// Runs all tasks until none can continue now.
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

    pub fn diagnostics(&self) -> Option<&'static Diagnostics> {
        Some(self.powered.as_ref()?.diagnostics)
    }

    /// The node, while it has power.
    pub fn node(&self) -> Option<&dyn Running> {
        Some(self.powered.as_ref()?.node.as_ref())
    }

    /// Spawns a task that runs until it ends or the node loses its power.
    ///
    /// # Panics
    /// Without power.
    pub fn spawn(&self, task: impl Future<Output = ()> + 'static) {
        let powered = self.powered.as_ref().unwrap_or_else(|| panic!("{:?} has no power", self.key));
        powered.pool.spawner().spawn(task);
    }
}

/// Environment of firmware at power-on.
pub(crate) struct Shell<'a> {
    spawner: Spawner,
    clock: &'a MockClock,
    ports: &'a PerBus<MockPort>,
    has_one_controller: bool,
    diagnostics: &'static Diagnostics,
    diary: &'a Diary,
    reset: &'a Rc<Cell<bool>>,
}

impl Shell<'_> {
    /// Runs a node. Each power-on needs new memory, because handles to the old node may still be in use.
    fn run<N: Member>(&self, node: impl FnOnce() -> N) -> (Handle<N>, Events<N>) {
        let resources: &Resources<MockBoard, N> = Box::leak(Box::default());
        let (handle, events, runners) = resources.start(node, self.connection(), self.diagnostics);
        let Runners { nominal, redundant, due } = runners;
        self.spawn(async { nominal.run().await });
        self.spawn(async { redundant.run().await });
        self.spawn(async { due.run().await });
        (handle, Events::new(events, self.diary.clone(), self.reset.clone()))
    }

    fn connection(&self) -> Connection<PerBus<BoardPort>, MockClock> {
        let ports = if self.has_one_controller {
            let PerBus { nominal, redundant } = one_controller(self.ports);
            PerBus { nominal: BoardPort::Shared(nominal), redundant: BoardPort::Shared(redundant) }
        } else {
            PerBus::from_fn(|bus| BoardPort::Own(self.ports[bus].clone()))
        };
        Connection { ports, clock: self.clock.clone() }
    }

    fn spawn(&self, task: impl Future<Output = ()> + 'static) {
        self.spawner.spawn(task);
    }
}
