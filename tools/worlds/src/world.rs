//! Nodes on two buses, and the controls of the test: power, cables, frames of foreign nodes.

use std::cell::{Cell, Ref, RefCell};
use std::rc::Rc;

use can_twin::wire::bus::{Wire, WireConfig};
use can_twin::wire::controller::Controllers;
use can_twin::wire::controller::{Attachment, Controller, NodeIndex, Trace};
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::record::{Counters, Destruction, Observation};
use can_twin::wire::station::Station;
use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;
use ecss_can::nmt::{Command as NmtCommand, NmtMessage, Target};
use ecss_can::node::minimal::MinimalEvent;
use ecss_can::node::{Master, MasterRequest, Slave, SlaveEvent, SpacecraftDevice, Status};
use ecss_can::runner::Diagnostics;
use ecss_can::types::{Address, Bus, NmtState, NodeId, PerBus};

use crate::clock::MockClock;
use crate::key::NodeKey;
use crate::log::{Entry, NodeEvent};
use crate::member::{Handle, Member, Running};
use crate::port::MockPort;
use crate::task::Task;
use crate::timeline::{MAX_STEPS_PER_INSTANT, Timeline};
use crate::unit::{Planned, Unit};

/// Distance between neighbours on the cable in metres: node n is at n times this, a second master after the last one.
const SPACING_M: f64 = 2.0;
/// Node from which on neighbours are closer: a cable for 1 Mbit/s has 40 m.
const CROWDED: u8 = 16;
const CROWDED_SPACING_M: f64 = 0.05;
/// Distance from a slave board to the second one with its Node-ID, in metres.
const BESIDE_M: f64 = 1.0;
/// Position of a cut that separates the master, the first of two, from all slaves, in metres.
pub const NEXT_TO_MASTER_M: f64 = 3.0;

/// A spacecraft's nodes and buses in virtual time.
pub struct World {
    timeline: Rc<Timeline>,
    units: Vec<Unit>,
    cables: PerBus<Cable>,
    /// Power switched at given times, the next one last.
    switches: Vec<(Time, NodeKey)>,
    entries: Rc<RefCell<Vec<Entry>>>,
}

/// Returns the position of a node, or of a stub after the last node.
fn metres(places: u8) -> f64 {
    let crowded = places.saturating_sub(CROWDED);
    f64::from(places - crowded) * SPACING_M + f64::from(crowded) * CROWDED_SPACING_M
}

/// One bus: the wire, its controllers, and the observed frames.
struct Cable {
    wire: Wire,
    plugs: Plugs,
    seen: Vec<Rc<Sent>>,
    torn: usize,
    misread: usize,
}

/// The controllers of one wire: those of the boards, then the injector.
struct Plugs {
    ports: Vec<MockPort>,
    /// Foreign node, which takes part from its first frame on.
    injector: Station,
    timing: BitTiming,
    /// State of any of these controllers has changed.
    changed: Rc<Cell<bool>>,
}

/// A frame that completed on a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    /// Falling edge of SOF.
    pub start: Time,
    /// End of EOF, both at the transmitter.
    pub end: Time,
    /// Node that sent it; `None` is the injector.
    pub node: Option<NodeId>,
    /// Board that sent it; `None` is the injector.
    pub key: Option<NodeKey>,
    /// The frame.
    pub frame: WireFrame,
    /// Number of controllers that received it.
    pub receivers: usize,
}

impl Sent {
    /// The 11-bit identifier; `None` for a 29-bit one.
    pub fn id(&self) -> Option<u16> {
        match self.frame.id {
            WireId::Standard(raw) => Some(raw),
            WireId::Extended(_) => None,
        }
    }
}

impl Controllers for Plugs {
    fn visit(&mut self, node: NodeIndex, visit: &mut dyn FnMut(&mut dyn Controller)) {
        match self.ports.get_mut(node) {
            Some(port) => visit(port),
            None => visit(&mut self.injector),
        }
    }

    fn have_changed(&mut self) -> bool {
        self.changed.take()
    }
}

impl Cable {
    fn advance(&mut self, now: Time, units: &[Unit]) {
        self.wire.advance(now, &mut self.plugs);
        let sent = |trace: &Trace, receivers: usize| {
            let key = units.get(trace.transmitter).map(|unit| unit.key);
            let node = key.map(NodeKey::node);
            Sent { start: trace.start, end: trace.end, node, key, frame: trace.frame, receivers }
        };
        for record in self.wire.take_records() {
            match record {
                Observation::Completed { trace, receivers, .. } => {
                    self.seen.push(Rc::new(sent(&trace, receivers.len())));
                }
                Observation::Destroyed { cause: Destruction::TransmitterLeft, .. } => self.torn += 1,
                Observation::Misread { .. } => self.misread += 1,
                Observation::Destroyed { .. }
                | Observation::ReceivedLate { .. }
                | Observation::Error { .. }
                | Observation::Fault { .. } => {}
            }
        }
    }
}

impl World {
    pub(crate) fn new(planned: Vec<Planned>, timing: BitTiming) -> World {
        let timeline = Timeline::new();
        let entries = Rc::default();
        let mut switches: Vec<_> = planned.iter().map(|node| (node.power_on, node.key)).collect();
        switches.sort_by_key(|switch| std::cmp::Reverse(*switch));
        let changed = PerBus::from_fn(|_| Rc::new(Cell::new(true)));
        let unit = |node: Planned| Unit::new(node, timeline.clone(), Rc::clone(&entries), &changed);
        let units: Vec<Unit> = planned.into_iter().map(unit).collect();
        let end = units.iter().map(|unit| unit.key.node().get()).max().unwrap_or(0);
        let cables = PerBus::from_fn(|bus| {
            let mut wire = Wire::new(WireConfig::default());
            for unit in &units {
                wire.attach(match unit.key {
                    NodeKey::SECOND_MASTER => metres(end + 1),
                    key if key.is_second() => metres(key.node().get()) + BESIDE_M,
                    key => metres(key.node().get()),
                });
            }
            // The injector is at the end.
            let is_pair = units.iter().any(|unit| unit.key == NodeKey::SECOND_MASTER);
            wire.attach(metres(end + 1 + u8::from(is_pair)));
            let ports: Vec<_> = units.iter().map(|unit| unit.port(bus).clone()).collect();
            ports.iter().for_each(|port| port.set_timing(timing));
            let injector = Station { attachment: None, ..Station::default() };
            Cable {
                wire,
                plugs: Plugs { ports, injector, timing, changed: changed[bus].clone() },
                seen: Vec::new(),
                torn: 0,
                misread: 0,
            }
        });
        World { timeline, units, cables, switches, entries }
    }

    /// The boards.
    pub(crate) fn units(&self) -> &[Unit] {
        &self.units
    }

    /// Returns the present.
    pub fn now(&self) -> Time {
        self.timeline.now()
    }

    /// Runs up to and including `end`.
    ///
    /// # Panics
    /// When time stands still, or `end` is in the past.
    pub fn run_until(&mut self, end: Time) {
        let mut standing = 0;
        loop {
            self.settle();
            let now = self.now();
            let wires = Bus::ALL.into_iter().filter_map(|bus| self.cables[bus].wire.next_event());
            let switch = self.switches.last().map(|(at, _)| *at);
            let next = wires.chain(self.timeline.next_wake()).chain(switch).min().map(|at| at.max(now));
            let Some(next) = next.filter(|next| *next <= end) else { break };
            standing = if next == now { standing + 1 } else { 0 };
            assert!(standing < MAX_STEPS_PER_INSTANT, "time stands still at {now:?}");
            self.go_to(next);
        }
        self.go_to(end);
        self.settle();
    }

    /// Runs for `span` from now.
    pub fn run_for(&mut self, span: Time) {
        self.run_until(self.now() + span);
    }

    fn go_to(&mut self, at: Time) {
        self.timeline.advance(at);
        while let Some((_, node)) = self.switches.pop_if(|(due, _)| *due <= at) {
            self.power_on(node);
            if self.switches.is_empty() {
                self.pdo_mismatches().iter().for_each(|mismatch| eprintln!("{mismatch}"));
            }
        }
        self.advance_wires();
    }

    /// Runs boards and wires alternately until neither has work at this instant.
    ///
    /// # Panics
    /// When they never finish.
    fn settle(&mut self) {
        for _ in 0..MAX_STEPS_PER_INSTANT {
            self.units.iter_mut().for_each(Unit::run);
            let before = self.timeline.interrupts();
            self.advance_wires();
            if self.timeline.interrupts() == before {
                return;
            }
        }
        panic!("boards and wires talk without end at {:?}", self.now());
    }

    fn advance_wires(&mut self) {
        for bus in Bus::ALL {
            self.cables[bus].advance(self.timeline.now(), &self.units);
        }
    }

    /// Applies a fault to a bus now, or its end.
    ///
    /// # Panics
    /// When the fault is impossible: a mistake in a test.
    pub fn strike(&mut self, bus: Bus, fault: Fault) {
        let at = self.now();
        self.cables[bus].wire.schedule(at, fault).expect("a fault of this wire");
    }

    /// Cuts a bus now, at `position_m` metres from its left end.
    pub fn cut(&mut self, bus: Bus, position_m: f64) {
        self.strike(bus, Fault::Cut { position_m });
    }

    /// Repairs every cut of a bus now.
    pub fn heal(&mut self, bus: Bus) {
        self.strike(bus, Fault::RestoreAll);
    }

    /// Index of a node on both wires, for [`World::strike`].
    pub fn index(&self, node: impl Into<NodeKey>) -> NodeIndex {
        let key = node.into();
        self.units.iter().position(|unit| unit.key == key).expect("a node of this world")
    }

    /// Returns whether the bus is not idle at the master's end.
    pub fn is_busy(&self, bus: Bus) -> bool {
        !self.cables[bus].wire.is_idle(0)
    }

    /// Totals of a wire.
    pub fn counters(&self, bus: Bus) -> Counters {
        self.cables[bus].wire.counters()
    }

    /// Switches a node on. Has no effect if it is on.
    pub fn power_on(&mut self, node: impl Into<NodeKey>) {
        let unit = self.unit_mut(node);
        if !unit.is_powered() {
            unit.power_on();
        }
    }

    /// Switches a node off.
    pub fn power_off(&mut self, node: impl Into<NodeKey>) {
        self.unit_mut(node).power_off();
    }

    /// Switches a node off and on again.
    pub fn reset(&mut self, node: impl Into<NodeKey>) {
        let node = node.into();
        self.power_off(node);
        self.power_on(node);
    }

    /// Returns whether a node has power.
    pub fn is_powered(&self, node: impl Into<NodeKey>) -> bool {
        self.unit(node).is_powered()
    }

    /// Makes a foreign node at the end of the cable send a frame as soon as possible.
    pub fn inject(&mut self, bus: Bus, frame: WireFrame) {
        let now = self.now();
        let plugs = &mut self.cables[bus].plugs;
        plugs.injector.attachment = Some(Attachment::new(plugs.timing));
        plugs.injector.queue.push_back((now, frame));
        plugs.changed.set(true);
    }

    /// Makes a request to the master, as its application does.
    ///
    /// # Panics
    /// When the master is off: a mistake in a test.
    pub fn request(&self, request: MasterRequest) {
        self.request_to(NodeKey::MASTER, request);
    }

    /// Makes a request to one of two masters, as its application does.
    ///
    /// # Panics
    /// When it is off: a mistake in a test.
    pub fn request_to(&self, master: NodeKey, request: MasterRequest) {
        let taken = self.running(master).request(request);
        assert!(taken, "the node with the master's Node-ID is a slave");
    }

    /// Commands the NMT state of a slave.
    pub fn nmt(&self, command: NmtCommand, target: Target) {
        self.request(MasterRequest::Nmt(NmtMessage { command, target }));
    }

    /// Spawns a future in the application of a node, which runs until it ends or the node loses its power.
    ///
    /// # Panics
    /// When the node is off: a mistake in a test.
    pub fn spawn<T: 'static>(
        &self,
        node: impl Into<NodeKey>,
        work: impl Future<Output = T> + 'static,
    ) -> Task<T> {
        let (task, future) = Task::new(work, self.timeline.clone());
        self.unit(node).spawn(future);
        task
    }

    /// Returns a handle of the master, valid until it is reset or loses its power.
    ///
    /// # Panics
    /// When it is off, or of another device: a mistake in a test.
    pub fn master<D: SpacecraftDevice>(&self) -> Handle<Master<D>> {
        self.node(NodeKey::MASTER)
    }

    /// Returns a handle of a slave, valid until it is reset or loses its power.
    ///
    /// # Panics
    /// When it is off, or of another device: a mistake in a test.
    pub fn slave<D: SpacecraftDevice>(&self, node: NodeId) -> Handle<Slave<D>> {
        self.node(node)
    }

    /// Returns a handle of the node of a board, valid until it is reset or loses its power.
    ///
    /// # Panics
    /// When it is off, or of another type: a mistake in a test.
    pub fn node<N: Member>(&self, key: impl Into<NodeKey>) -> Handle<N> {
        let key = key.into();
        let handle = self.running(key).handle().downcast_ref();
        *handle.unwrap_or_else(|| panic!("{key:?} is no {}", std::any::type_name::<N>()))
    }

    /// Writes an object of a node, as its application does.
    ///
    /// # Panics
    /// When the node is off, or refuses the value: a mistake in a test.
    pub fn write(&self, node: impl Into<NodeKey>, at: Address, value: &[u8]) {
        self.running(node).write(at, value).expect("the value is allowed");
    }

    /// Returns the present status of a node.
    ///
    /// # Panics
    /// When it is off, or a minimal slave: a mistake in a test.
    pub fn status(&self, node: impl Into<NodeKey>) -> Status {
        self.running(node).status().expect("a node with an object dictionary")
    }

    /// Returns all events so far.
    pub fn log(&self) -> Ref<'_, [Entry]> {
        Ref::map(self.entries.borrow(), Vec::as_slice)
    }

    /// Returns the events of one node so far, in chronological order.
    pub fn log_of(&self, node: impl Into<NodeKey>) -> Vec<(Time, NodeEvent)> {
        let key = node.into();
        self.log().iter().filter(|entry| entry.key == key).map(|entry| (entry.at, entry.what)).collect()
    }

    /// Frames completed on a bus so far.
    pub fn frames(&self, bus: Bus) -> &[Rc<Sent>] {
        &self.cables[bus].seen
    }

    /// Returns the number of frames whose transmitter left the bus, or lost power, before their end.
    pub fn torn_frames(&self, bus: Bus) -> usize {
        self.cables[bus].torn
    }

    /// Returns the number of frames that a node received although no node sent them.
    pub fn misread_frames(&self, bus: Bus) -> usize {
        self.cables[bus].misread
    }

    /// Returns the NMT state of a slave as reported to its application; `None` without power. A minimal slave is always
    /// Operational.
    pub fn state(&self, node: NodeId) -> Option<NmtState> {
        self.last(node, |event| match event {
            NodeEvent::Slave(SlaveEvent::State(state)) => Some(*state),
            NodeEvent::Minimal(_) => Some(NmtState::Operational),
            _ => None,
        })
    }

    /// Returns the bus that a slave considers active; `None` without power.
    pub fn active(&self, node: NodeId) -> Option<Bus> {
        self.last(node, |event| match event {
            NodeEvent::Slave(SlaveEvent::ActiveBus { bus, .. })
            | NodeEvent::Minimal(MinimalEvent::ActiveBus { bus, .. }) => Some(*bus),
            _ => None,
        })
    }

    /// The bus of the master, the first of two.
    ///
    /// # Panics
    /// When it is off: a mistake in a test.
    pub fn master_bus(&self) -> Bus {
        self.status(NodeKey::MASTER).active
    }

    /// Masters that have power and manage the network.
    pub fn active_masters(&self) -> Vec<NodeKey> {
        let active = |unit: &&Unit| unit.node().is_some_and(Running::is_active_master);
        self.units.iter().filter(active).map(|unit| unit.key).collect()
    }

    /// All slaves, powered or not.
    pub fn slaves(&self) -> Vec<NodeId> {
        self.units.iter().map(|unit| unit.key.node()).filter(|id| *id != NodeId::MASTER).collect()
    }

    /// Returns whether one master is active, and every slave Operational on its bus.
    pub fn all_operational(&self) -> bool {
        let [master] = self.active_masters()[..] else { return false };
        let bus = Some(self.status(master).active);
        let here = |id: NodeId| self.state(id) == Some(NmtState::Operational) && self.active(id) == bus;
        self.slaves().into_iter().all(here)
    }

    /// The clock of a node, while it has power.
    pub fn clock(&self, node: impl Into<NodeKey>) -> Option<MockClock> {
        self.unit(node).clock().cloned()
    }

    /// The counters of a node, while it has power.
    pub fn diagnostics(&self, node: impl Into<NodeKey>) -> Option<&'static Diagnostics> {
        self.unit(node).diagnostics()
    }

    /// The controller of a node on a bus.
    pub fn port(&self, node: impl Into<NodeKey>, bus: Bus) -> &MockPort {
        self.unit(node).port(bus)
    }

    fn last<T>(&self, node: NodeId, pick: impl Fn(&NodeEvent) -> Option<T>) -> Option<T> {
        if !self.is_powered(node) {
            return None;
        }
        let log = self.log();
        let life = log.iter().rev().filter(|entry| entry.node == node);
        life.take_while(|entry| entry.what != NodeEvent::PowerOn).find_map(|entry| pick(&entry.what))
    }

    fn running(&self, node: impl Into<NodeKey>) -> &dyn Running {
        let key = node.into();
        self.unit(key).node().unwrap_or_else(|| panic!("{key:?} has no power"))
    }

    fn unit(&self, node: impl Into<NodeKey>) -> &Unit {
        let key = node.into();
        self.units.iter().find(|unit| unit.key == key).expect("a node of this world")
    }

    fn unit_mut(&mut self, node: impl Into<NodeKey>) -> &mut Unit {
        let key = node.into();
        self.units.iter_mut().find(|unit| unit.key == key).expect("a node of this world")
    }
}
