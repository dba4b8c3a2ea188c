//! Nodes on two buses, and the hands of the test: power, cables, frames of strangers.

use std::cell::{Ref, RefCell};
use std::rc::Rc;

use can_wire::controller::{Controller, NodeIndex, Trace};
use can_wire::fault::Fault;
use can_wire::frame::{WireFrame, WireId};
use can_wire::record::{Counters, Destruction, Record};
use can_wire::time::Time;
use can_wire::wire::{Controllers, Wire, WireConfig};
use ecss_can::nmt::{Command as NmtCommand, NmtMessage, Target};
use ecss_can::node::{MasterEvent, MasterRequest, Refusal, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::runner::Telltale;
use ecss_can::types::{Address, Bus, NmtState, NodeId, PerBus};
use mission::{Command, Request};

use crate::application::{MasterHandle, MissionMaster, MissionSlave};
use crate::board::Board;
use crate::builder::Builder;
use crate::clock::MockClock;
use crate::log::{Entry, Happening};
use crate::port::MockPort;
use crate::rogue::Rogue;
use crate::task::Task;
use crate::timeline::Timeline;

/// Distance between neighbours on the cable: node n sits at n times this many metres.
const SPACING_M: f64 = 2.0;
/// Where a cut separates the master from all slaves.
pub const NEXT_TO_MASTER_M: f64 = 3.0;
/// Steps without time going on: somebody wakes for nothing.
const MAX_STEPS_PER_INSTANT: u32 = 10_000;

/// A spacecraft's nodes and buses in virtual time.
pub struct World {
    profile: Profile,
    timeline: Rc<Timeline>,
    boards: Vec<Board>,
    cables: PerBus<Cable>,
    /// Power switched at given times, the next one last.
    switches: Vec<(Time, NodeId)>,
    entries: Rc<RefCell<Vec<Entry>>>,
}

/// One bus: the wire, what is plugged in, what was seen.
struct Cable {
    wire: Wire,
    plugs: Plugs,
    seen: Vec<Rc<Sent>>,
    torn: usize,
    misread: usize,
}

/// The controllers of one wire: those of the boards, then the rogue.
struct Plugs {
    ports: Vec<MockPort>,
    rogue: Rogue,
}

/// A frame that completed on a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    /// Falling edge of SOF.
    pub start: Time,
    /// End of EOF, both at the transmitter.
    pub end: Time,
    /// Who; `None` is the rogue.
    pub node: Option<NodeId>,
    /// What.
    pub frame: WireFrame,
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
    fn controller(&mut self, node: NodeIndex) -> &mut dyn Controller {
        match self.ports.get_mut(node) {
            Some(port) => port,
            None => &mut self.rogue,
        }
    }
}

impl Cable {
    fn advance(&mut self, now: Time, boards: &[Board]) {
        self.wire.advance(now, &mut self.plugs);
        let sent = |trace: &Trace| Sent {
            start: trace.start,
            end: trace.end,
            node: boards.get(trace.transmitter).map(|board| board.id),
            frame: trace.frame,
        };
        for record in self.wire.take_records() {
            match record {
                Record::Completed { trace, .. } => self.seen.push(Rc::new(sent(&trace))),
                Record::Destroyed { cause: Destruction::TransmitterLeft, .. } => self.torn += 1,
                Record::Misread { .. } => self.misread += 1,
                Record::Destroyed { .. } | Record::Error { .. } | Record::Fault { .. } => {}
            }
        }
    }
}

impl World {
    /// A world to be: the master and slaves 2, 3, .., `slaves` of them.
    pub fn builder(profile: Profile, slaves: u8) -> Builder {
        Builder::new(profile, slaves)
    }

    pub(crate) fn new(profile: Profile, boards: Vec<(NodeId, i32, Time)>, traffic: bool) -> World {
        let timeline = Timeline::new();
        let entries = Rc::default();
        let slaves = boards.iter().map(|(id, ..)| *id).filter(|id| traffic && *id != NodeId::MASTER);
        let traffic: Vec<NodeId> = slaves.collect();
        let mut switches: Vec<_> = boards.iter().map(|(id, _, on)| (*on, *id)).collect();
        switches.sort_by_key(|switch| std::cmp::Reverse(*switch));
        let boards: Vec<Board> = boards
            .into_iter()
            .map(|(id, ppm, _)| {
                Board::new(id, ppm, profile, traffic.clone(), timeline.clone(), Rc::clone(&entries))
            })
            .collect();
        let cables = PerBus::from_fn(|bus| {
            let mut wire = Wire::new(WireConfig::default());
            for board in &boards {
                wire.attach(f64::from(board.id.get()) * SPACING_M);
            }
            wire.attach((boards.len() + 1) as f64 * SPACING_M);
            let ports = boards.iter().map(|board| board.port(bus).clone()).collect();
            Cable {
                wire,
                plugs: Plugs { ports, rogue: Rogue::default() },
                seen: Vec::new(),
                torn: 0,
                misread: 0,
            }
        });
        World { profile, timeline, boards, cables, switches, entries }
    }

    /// The present.
    pub fn now(&self) -> Time {
        self.timeline.now()
    }

    /// Everything up to and including `end`.
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

    /// Everything within `span` from now.
    pub fn run_for(&mut self, span: Time) {
        self.run_until(self.now() + span);
    }

    fn go_to(&mut self, at: Time) {
        self.timeline.advance(at);
        while let Some((_, node)) = self.switches.pop_if(|(due, _)| *due <= at) {
            self.power_on(node);
        }
        self.advance_wires();
    }

    /// Lets boards and wires talk until neither has anything to say at this instant.
    fn settle(&mut self) {
        loop {
            self.boards.iter_mut().for_each(Board::run);
            let before = self.timeline.interrupts();
            self.advance_wires();
            if self.timeline.interrupts() == before {
                return;
            }
        }
    }

    fn advance_wires(&mut self) {
        for bus in Bus::ALL {
            self.cables[bus].advance(self.timeline.now(), &self.boards);
        }
    }

    /// Lets something go wrong on a bus now, or heals it.
    ///
    /// # Panics
    /// When it cannot happen: a mistake in a test.
    pub fn strike(&mut self, bus: Bus, fault: Fault) {
        let at = self.now();
        self.cables[bus].wire.schedule(at, fault).expect("a fault of this wire");
    }

    /// Cuts a bus now, so many metres from its left end.
    pub fn cut(&mut self, bus: Bus, position_m: f64) {
        self.strike(bus, Fault::Cut { position_m });
    }

    /// Heals every cut of a bus now.
    pub fn heal(&mut self, bus: Bus) {
        self.strike(bus, Fault::RestoreAll);
    }

    /// Index of a node on both wires, for [`World::strike`].
    pub fn index(&self, node: NodeId) -> NodeIndex {
        self.boards.iter().position(|board| board.id == node).expect("a node of this world")
    }

    /// Totals of a wire.
    pub fn counters(&self, bus: Bus) -> Counters {
        self.cables[bus].wire.counters()
    }

    /// Switches a node on; nothing happens when it is.
    pub fn power_on(&mut self, node: NodeId) {
        let board = self.board_mut(node);
        if !board.is_powered() {
            board.power_on();
        }
    }

    /// Switches a node off.
    pub fn power_off(&mut self, node: NodeId) {
        self.board_mut(node).power_off();
    }

    /// Off and on again.
    pub fn reset(&mut self, node: NodeId) {
        self.power_off(node);
        self.power_on(node);
    }

    /// Whether a node has power.
    pub fn is_powered(&self, node: NodeId) -> bool {
        self.board(node).is_powered()
    }

    /// A stranger at the end of the cable sends a frame as soon as the bus lets it.
    pub fn inject(&mut self, bus: Bus, frame: WireFrame) {
        let now = self.now();
        self.cables[bus].plugs.rogue.send(now, frame);
    }

    /// The application of the master asks for something.
    ///
    /// # Panics
    /// When the master is off: a mistake in a test.
    pub fn request(&mut self, request: MasterRequest) {
        self.board(NodeId::MASTER).master().expect("the master has power").request(request);
    }

    /// Sends a telecommand.
    ///
    /// # Panics
    /// When the master is off, or on for less than a command's lifetime: a mistake in a test.
    pub fn command(&mut self, node: NodeId, command: Command) -> Result<(), Refusal> {
        let sequences = self.board(NodeId::MASTER).sequences().expect("the master has power");
        let message = sequences.encode(node, command).expect("the master is on for long enough");
        let master = self.board(NodeId::MASTER).master().expect("the master has power");
        master.with(|master, now| mission::command(master, node, &message, now))
    }

    /// Asks for telemetry.
    ///
    /// # Panics
    /// When the master is off: a mistake in a test.
    pub fn ask(&mut self, node: NodeId, request: Request) -> Result<(), Refusal> {
        let master = self.board(NodeId::MASTER).master().expect("the master has power");
        master.with(|master, now| mission::request(master, node, &request.encode(), now))
    }

    /// Commands the NMT state of a slave.
    pub fn nmt(&mut self, command: NmtCommand, target: Target) {
        self.request(MasterRequest::Nmt(NmtMessage { command, target }));
    }

    /// The application of the master begins to do something with its node.
    ///
    /// # Panics
    /// When the master is off: a mistake in a test.
    pub fn on_master<T: 'static, F: Future<Output = T> + 'static>(
        &self,
        work: impl FnOnce(MasterHandle) -> F,
    ) -> Task<T> {
        let board = self.board(NodeId::MASTER);
        let master = board.master().expect("the master has power");
        let (task, future) = Task::new(work(master), self.timeline.clone());
        board.spawn(future);
        task
    }

    /// Looks at the master.
    ///
    /// # Panics
    /// When it is off: a mistake in a test.
    pub fn master<R>(&self, look: impl FnOnce(&mut MissionMaster) -> R) -> R {
        self.board(NodeId::MASTER).master().expect("the master has power").with(|master, _| look(master))
    }

    /// Looks at a slave.
    ///
    /// # Panics
    /// When it is off: a mistake in a test.
    pub fn slave<R>(&self, node: NodeId, look: impl FnOnce(&mut MissionSlave) -> R) -> R {
        self.board(node).slave().expect("the slave has power").with(|slave, _| look(slave))
    }

    /// The application of a node writes an object.
    ///
    /// # Panics
    /// When the node is off, or refuses the value: a mistake in a test.
    pub fn write(&self, node: NodeId, at: Address, value: &[u8]) {
        let board = self.board(node);
        let written = match (board.master(), board.slave()) {
            (Some(master), _) => master.write(at, value),
            (_, Some(slave)) => slave.write(at, value),
            _ => panic!("{node:?} has no power"),
        };
        written.expect("the value is allowed");
    }

    /// What happened so far.
    pub fn log(&self) -> Ref<'_, [Entry]> {
        Ref::map(self.entries.borrow(), Vec::as_slice)
    }

    /// What happened on one node so far, in the order of time.
    pub fn log_of(&self, node: NodeId) -> Vec<(Time, Happening)> {
        self.log().iter().filter(|entry| entry.node == node).map(|entry| (entry.at, entry.what)).collect()
    }

    /// Frames completed on a bus so far.
    pub fn frames(&self, bus: Bus) -> &[Rc<Sent>] {
        &self.cables[bus].seen
    }

    /// Frames whose transmitter left the bus, or lost power, before their end.
    pub fn torn_frames(&self, bus: Bus) -> usize {
        self.cables[bus].torn
    }

    /// Frames that a node received and nobody sent.
    pub fn misread_frames(&self, bus: Bus) -> usize {
        self.cables[bus].misread
    }

    /// NMT state of a slave as it told its application; `None` without power.
    pub fn state(&self, node: NodeId) -> Option<NmtState> {
        self.last(node, |event| match event {
            SlaveEvent::State(state) => Some(*state),
            _ => None,
        })
    }

    /// The bus a slave considers active; `None` without power.
    pub fn active(&self, node: NodeId) -> Option<Bus> {
        self.last(node, |event| match event {
            SlaveEvent::ActiveBus { bus, .. } => Some(*bus),
            _ => None,
        })
    }

    /// The bus of the master.
    pub fn master_bus(&self) -> Bus {
        let log = self.log();
        let life = log.iter().rev().filter(|entry| entry.node == NodeId::MASTER);
        let switched =
            life.take_while(|entry| entry.what != Happening::PowerOn).find_map(|entry| match entry.what {
                Happening::Master(MasterEvent::BusSwitched { to, .. }) => Some(to),
                _ => None,
            });
        switched.unwrap_or(self.profile.bdefault)
    }

    /// All slaves, powered or not.
    pub fn slaves(&self) -> Vec<NodeId> {
        self.boards.iter().map(|board| board.id).filter(|id| *id != NodeId::MASTER).collect()
    }

    /// Whether every slave is Operational on the bus of the master.
    pub fn all_operational(&self) -> bool {
        let bus = Some(self.master_bus());
        let here = |id: NodeId| self.state(id) == Some(NmtState::Operational) && self.active(id) == bus;
        self.slaves().into_iter().all(here)
    }

    /// The clock of a node, while it has power.
    pub fn clock(&self, node: NodeId) -> Option<MockClock> {
        self.board(node).clock().cloned()
    }

    /// The counters of a node, while it has power.
    pub fn telltale(&self, node: NodeId) -> Option<&'static Telltale> {
        self.board(node).telltale()
    }

    /// The controller of a node on a bus.
    pub fn port(&self, node: NodeId, bus: Bus) -> &MockPort {
        self.board(node).port(bus)
    }

    fn last<T>(&self, node: NodeId, pick: impl Fn(&SlaveEvent) -> Option<T>) -> Option<T> {
        if !self.is_powered(node) {
            return None;
        }
        let log = self.log();
        let life = log.iter().rev().filter(|entry| entry.node == node);
        life.take_while(|entry| entry.what != Happening::PowerOn).find_map(|entry| match &entry.what {
            Happening::Slave(event) => pick(event),
            _ => None,
        })
    }

    fn board(&self, node: NodeId) -> &Board {
        self.boards.iter().find(|board| board.id == node).expect("a node of this world")
    }

    fn board_mut(&mut self, node: NodeId) -> &mut Board {
        self.boards.iter_mut().find(|board| board.id == node).expect("a node of this world")
    }
}
