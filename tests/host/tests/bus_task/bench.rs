//! The tasks of a node on mock ports, and a node that is controlled by the test.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use can_twin::wire::controller::{Controller, ErrorCounters, ErrorKind, WireEvent};
use can_twin::wire::frame::{WireFrame, WireId};
use can_twin::wire::time::Time;
use ecss_can::link::machine::Outgoing;
use ecss_can::link::port::Filter;
use ecss_can::node::extend::{BusCommand, Filters, FullDepth, LinkEvent, Turn};
use ecss_can::node::{FailCause, Node};
use ecss_can::runner::extend::WholeNode;
use ecss_can::runner::{Connection, Diagnostics, Handle, Resources, Runners, Single, SingleRunners};
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, PerBus};
use ecss_can_worlds::MockBoard;
use ecss_can_worlds::clock::MockClock;
use ecss_can_worlds::port::{BIT, BoardPort, MockPort};
use ecss_can_worlds::timeline::Timeline;
use futures_executor::LocalPool;
use futures_util::future::LocalBoxFuture;
use futures_util::task::LocalSpawnExt;

/// A node that is controlled by the test and records its events.
#[derive(Clone, Default)]
pub struct Probe {
    pub told: Rc<RefCell<Vec<LinkEvent>>>,
    /// Number of calls of [`Node::poll`].
    pub polls: Rc<Cell<usize>>,
    /// Deadline until the next poll.
    pub due: Rc<Cell<Option<Instant>>>,
    /// Frames it sends for every frame it receives.
    pub replies: u8,
    /// Filters in addition to the one for heartbeats.
    pub others: Vec<Filter>,
}

impl Node for Probe {
    type Event = ();
    type Request = BusCommand;
    type Depth = FullDepth;

    fn filters(&self) -> Filters {
        [Filter::function(id(0x700))].into_iter().chain(self.others.iter().copied()).collect()
    }

    fn filter(&self, number: usize) -> Option<Filter> {
        self.filters().get(number).copied()
    }

    fn start(&mut self, turn: &mut Turn<'_, ()>) {
        turn.out.command(Bus::Nominal, BusCommand::Join);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn<'_, ()>) {
        self.told.borrow_mut().push(*event);
        if matches!(event, LinkEvent::Received { .. }) {
            (0..self.replies).for_each(|byte| {
                turn.out.command(
                    bus,
                    BusCommand::Send(Outgoing { frame: frame(0x385, byte), expires: Instant::NEVER }),
                )
            });
        }
    }

    fn on_request(&mut self, request: BusCommand, turn: &mut Turn<'_, ()>) {
        turn.out.command(Bus::Nominal, request);
    }

    fn poll(&mut self, turn: &mut Turn<'_, ()>) {
        self.polls.set(self.polls.get() + 1);
        if self.due.get().is_some_and(|due| due <= turn.now) {
            self.due.take();
        }
    }

    fn deadline(&self) -> Option<Instant> {
        self.due.get()
    }

    fn is_stamped(&self, _: Bus, frame: &Frame) -> bool {
        frame.id() == CobId::SYNC
    }
}

/// A node with its nominal bus; its tasks run from [`Bench::start`] on.
pub struct Bench<N: Node = Probe> {
    pub pool: LocalPool,
    pub timeline: Rc<Timeline>,
    pub wire: MockPort,
    pub node: Handle<MockBoard, N>,
    tasks: Vec<LocalBoxFuture<'static, ()>>,
    /// Instants at which a timer of the node fired.
    pub wakes: usize,
    pub probe: Probe,
}

impl Bench {
    pub fn new(replies: u8) -> Bench {
        Bench::with(Probe { replies, ..Probe::default() })
    }

    pub fn with(probe: Probe) -> Bench {
        let timeline = Timeline::new();
        let clock = MockClock::power_on(timeline.clone(), 0);
        let wires = PerBus::from_fn(|_| MockPort::new(clock.clone()));
        let wire = wires.nominal.clone();
        let ports = PerBus::from_fn(|bus| BoardPort::Own(wires[bus].clone()));
        let diagnostics: &Diagnostics = Box::leak(Box::default());
        let resources: &Resources<MockBoard, Probe> = Box::leak(Box::default());
        let (node, _, runners) = resources.start(|| probe.clone(), Connection { ports, clock }, diagnostics);
        let Runners { nominal, redundant, due } = runners;
        let tasks: Vec<LocalBoxFuture<'static, ()>> = vec![
            Box::pin(async { nominal.run().await }),
            Box::pin(async { redundant.run().await }),
            Box::pin(async { due.run().await }),
        ];
        Bench { pool: LocalPool::new(), timeline, wire, node, tasks, wakes: 0, probe }
    }

    /// Makes a bench with a running node that has joined the bus.
    pub fn joined(replies: u8) -> Bench {
        let mut bench = Bench::new(replies);
        bench.start();
        bench.see_eleven_recessive_bits();
        bench
    }

    pub fn command(&mut self, command: BusCommand) {
        self.node.request(command);
        self.pool.run_until_stalled();
    }

    pub fn send(&mut self, raw: u16, byte: u8) {
        self.command(BusCommand::Send(Outgoing { frame: frame(raw, byte), expires: Instant::NEVER }));
    }

    pub fn send_for(&mut self, raw: u16, byte: u8, lifetime: Duration) {
        let expires = self.node.now() + lifetime;
        self.command(BusCommand::Send(Outgoing { frame: frame(raw, byte), expires }));
    }
}

impl<N: Node> Bench<N> {
    /// Makes a bench with a node on one bus. `probe` is the node, or not in use.
    pub fn on_one_bus(node: impl FnOnce() -> N, probe: Probe) -> Self {
        let timeline = Timeline::new();
        let clock = MockClock::power_on(timeline.clone(), 0);
        let wire = MockPort::new(clock.clone());
        let diagnostics: &Diagnostics = Box::leak(Box::default());
        let resources: &Single<MockBoard, N> = Box::leak(Box::default());
        let port = BoardPort::Own(wire.clone());
        let (node, _, SingleRunners { bus, due }) =
            resources.start(node, Connection { ports: port, clock }, diagnostics);
        let tasks: Vec<LocalBoxFuture<'static, ()>> =
            vec![Box::pin(async { bus.run().await }), Box::pin(async { due.run().await })];
        Bench { pool: LocalPool::new(), timeline, wire, node, tasks, wakes: 0, probe }
    }

    pub fn start(&mut self) {
        let spawner = self.pool.spawner();
        let spawned: Vec<_> = self.tasks.drain(..).map(|task| spawner.spawn_local(task)).collect();
        assert!(spawned.iter().all(Result::is_ok), "the pool lives");
        self.pool.run_until_stalled();
    }

    pub fn diagnostics(&self) -> &Diagnostics {
        self.node.diagnostics()
    }

    pub fn run_for(&mut self, span: Time) {
        let end = self.timeline.now() + span;
        self.pool.run_until_stalled();
        while let Some(at) = self.timeline.next_wake().filter(|at| *at <= end) {
            self.timeline.advance(at);
            self.wakes += 1;
            self.pool.run_until_stalled();
        }
        self.timeline.advance(end);
        self.pool.run_until_stalled();
    }

    pub fn see_eleven_recessive_bits(&mut self) {
        self.run_for(Time(11 * BIT.0));
        self.wire.on_wire(self.timeline.now(), &WireEvent::Joined);
    }

    /// Starts an arbitration, and returns the frame that the port sends.
    pub fn begin(&mut self) -> Option<WireFrame> {
        let sent = self.wire.contend(self.timeline.now())?;
        self.wire.on_wire(self.timeline.now(), &WireEvent::Started);
        Some(sent)
    }

    /// Ends the frame on the wire with this event, 100 us later.
    pub fn end(&mut self, event: WireEvent) {
        self.run_for(Time(100 * BIT.0));
        self.tell(event);
    }

    pub fn tell(&mut self, event: WireEvent) {
        self.wire.on_wire(self.timeline.now(), &event);
        self.pool.run_until_stalled();
    }

    /// Lets an attempt fail, and sets the error counters.
    pub fn fail(&mut self, kind: ErrorKind, transmit: u16) {
        self.begin().expect("automatic retransmission");
        self.end(WireEvent::TransmitError(kind));
        self.tell(WireEvent::Counters(ErrorCounters { transmit, receive: 0 }));
    }

    pub fn is_on_bus(&self) -> bool {
        self.wire.attachment().is_some()
    }

    /// Sends all pending frames, in 100 us each, and returns their identifiers and first data bytes.
    pub fn drain(&mut self) -> Vec<(u16, u8)> {
        let mut sent = Vec::new();
        while let Some(frame) = self.begin() {
            sent.push((raw_id(&frame), frame.data[0]));
            self.end(WireEvent::Transmitted);
        }
        sent
    }

    /// Receives a frame of a peer at once.
    pub fn receive(&mut self, sent: WireFrame) {
        self.wire.on_wire(self.timeline.now(), &WireEvent::Received(sent));
    }

    pub fn receive_heartbeats(&mut self, bytes: std::ops::Range<u16>) {
        for byte in bytes {
            self.receive(WireFrame::standard(0x700, &byte.to_le_bytes()));
        }
        self.pool.run_until_stalled();
    }

    pub fn failures(&self) -> Vec<(u8, FailCause)> {
        let told = self.probe.told.borrow();
        let failed = told.iter().filter_map(|event| match event {
            LinkEvent::Failed { frame, cause } => Some((frame.data()[0], *cause)),
            _ => None,
        });
        failed.collect()
    }

    pub fn transmitted(&self) -> usize {
        let told = self.probe.told.borrow();
        told.iter().filter(|event| matches!(event, LinkEvent::Transmitted { .. })).count()
    }

    pub fn received(&self) -> Vec<u16> {
        let told = self.probe.told.borrow();
        let received = told.iter().filter_map(|event| match event {
            LinkEvent::Received { frame, .. } => Some(u16::from_le_bytes(frame.data().try_into().ok()?)),
            _ => None,
        });
        received.collect()
    }

    pub fn lost(&self) -> u32 {
        let told = self.probe.told.borrow();
        let lost = told.iter().map(|event| match event {
            LinkEvent::Overrun { lost } => u32::from(*lost),
            _ => 0,
        });
        lost.sum()
    }
}

pub fn id(raw: u16) -> CobId {
    CobId::new(raw).expect("an 11-bit identifier")
}

pub fn frame(raw: u16, byte: u8) -> Frame {
    Frame::of(id(raw), [byte])
}

pub fn raw_id(frame: &WireFrame) -> u16 {
    match frame.id {
        WireId::Standard(raw) => raw,
        WireId::Extended(_) => panic!("our nodes never send 29-bit identifiers"),
    }
}
