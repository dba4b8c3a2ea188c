//! Both tasks on a mock port, and a node that obeys the test.

use std::cell::RefCell;
use std::rc::Rc;

use can_wire::controller::{Controller, ErrorCounters, ErrorKind, WireEvent};
use can_wire::frame::{WireFrame, WireId};
use can_wire::time::Time;
use ecss_can::link::port::{CanPort, Filter};
use ecss_can::link::queue::Outgoing;
use ecss_can::node::{BusCommand, FailCause, LinkEvent, Node, Outbox};
use ecss_can::runner::{AppLink, NodeCell, Telltale, bus_task, node_task};
use ecss_can::time::Clock;
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use futures_executor::LocalPool;
use futures_util::task::LocalSpawnExt;
use host_worlds::clock::MockClock;
use host_worlds::port::{BIT, MockPort};
use host_worlds::timeline::Timeline;

/// A node that obeys the test and remembers what it was told.
#[derive(Clone, Default)]
pub struct Probe {
    pub told: Rc<RefCell<Vec<LinkEvent>>>,
    /// Frames it sends for every frame it receives.
    pub replies: u8,
}

impl Node for Probe {
    type Event = ();
    type Request = BusCommand;

    fn start(&mut self, _: Instant, out: &mut Outbox<()>) {
        out.command(Bus::Nominal, BusCommand::Join);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, _: Instant, out: &mut Outbox<()>) {
        self.told.borrow_mut().push(*event);
        if matches!(event, LinkEvent::Received { .. }) {
            (0..self.replies).for_each(|byte| {
                out.command(
                    bus,
                    BusCommand::Send(Outgoing { frame: frame(0x385, byte), expires: Instant::NEVER }),
                )
            });
        }
    }

    fn on_request(&mut self, request: BusCommand, _: Instant, out: &mut Outbox<()>) {
        out.command(Bus::Nominal, request);
    }

    fn poll(&mut self, _: Instant, _: &mut Outbox<()>) {}

    fn deadline(&self) -> Option<Instant> {
        None
    }

    fn is_stamped(&self, _: Bus, frame: &Frame) -> bool {
        frame.id() == CobId::SYNC
    }
}

/// One bus task and one node task; the node task runs from [`Bench::start_node`] on.
pub struct Bench {
    pub pool: LocalPool,
    pub timeline: Rc<Timeline>,
    pub clock: MockClock,
    pub wire: MockPort,
    pub node: Rc<NodeCell<NoopRawMutex, Probe>>,
    pub app: Rc<AppLink<NoopRawMutex, (), BusCommand>>,
    pub telltale: Rc<Telltale>,
    pub probe: Probe,
}

impl Bench {
    pub fn new(replies: u8) -> Bench {
        let timeline = Timeline::new();
        let clock = MockClock::power_on(timeline.clone(), 0);
        let wire = MockPort::new(clock.clone());
        let probe = Probe { replies, ..Probe::default() };
        let node = Rc::new(NodeCell::new(probe.clone()));
        let (app, telltale) = (Rc::<AppLink<_, _, _>>::default(), Rc::<Telltale>::default());
        let bench = Bench { pool: LocalPool::new(), timeline, clock, wire, node, app, telltale, probe };
        let (mut port, clock, node) = (bench.wire.clone(), bench.clock.clone(), bench.node.clone());
        let (app, telltale) = (bench.app.clone(), bench.telltale.clone());
        port.set_filters(&[Filter::function(id(0x700))]);
        let task = async move {
            bus_task(Bus::Nominal, port, clock, &node, &app, &telltale).await;
        };
        bench.pool.spawner().spawn_local(task).expect("a new pool takes tasks");
        bench
    }

    /// Both tasks, on the bus.
    pub fn joined(replies: u8) -> Bench {
        let mut bench = Bench::new(replies);
        bench.start_node();
        bench.see_eleven_recessive_bits();
        bench
    }

    pub fn start_node(&mut self) {
        let (node, clock) = (self.node.clone(), self.clock.clone());
        let (app, telltale) = (self.app.clone(), self.telltale.clone());
        let task = async move {
            node_task(&node, clock, &app, &telltale).await;
        };
        self.pool.spawner().spawn_local(task).expect("the pool lives");
        self.pool.run_until_stalled();
    }

    pub fn run_for(&mut self, span: Time) {
        let end = self.timeline.now() + span;
        self.pool.run_until_stalled();
        while let Some(at) = self.timeline.next_wake().filter(|at| *at <= end) {
            self.timeline.advance(at);
            self.pool.run_until_stalled();
        }
        self.timeline.advance(end);
        self.pool.run_until_stalled();
    }

    pub fn see_eleven_recessive_bits(&mut self) {
        self.run_for(Time(11 * BIT.0));
        self.wire.on_wire(self.timeline.now(), &WireEvent::Joined);
    }

    pub fn command(&mut self, command: BusCommand) {
        assert!(self.app.requests.try_send(command).is_ok(), "the node takes requests");
        self.pool.run_until_stalled();
    }

    pub fn send(&mut self, raw: u16, byte: u8) {
        self.command(BusCommand::Send(Outgoing { frame: frame(raw, byte), expires: Instant::NEVER }));
    }

    pub fn send_for(&mut self, raw: u16, byte: u8, lifetime: Duration) {
        let expires = self.clock.now() + lifetime;
        self.command(BusCommand::Send(Outgoing { frame: frame(raw, byte), expires }));
    }

    /// An arbitration begins; the frame that the port puts on the wire.
    pub fn begin(&mut self) -> Option<WireFrame> {
        let sent = self.wire.contend(self.timeline.now())?;
        self.wire.on_wire(self.timeline.now(), &WireEvent::Started);
        Some(sent)
    }

    /// The frame on the wire ends like this, 100 us later.
    pub fn end(&mut self, event: WireEvent) {
        self.run_for(Time(100 * BIT.0));
        self.tell(event);
    }

    pub fn tell(&mut self, event: WireEvent) {
        self.wire.on_wire(self.timeline.now(), &event);
        self.pool.run_until_stalled();
    }

    /// An attempt fails, and the error counters are these after it.
    pub fn fail(&mut self, kind: ErrorKind, transmit: u16) {
        self.begin().expect("automatic retransmission");
        self.end(WireEvent::TransmitError(kind));
        self.tell(WireEvent::Counters(ErrorCounters { transmit, receive: 0 }));
    }

    pub fn is_on_bus(&self) -> bool {
        self.wire.attachment().is_some()
    }

    /// Sends what waits, in 100 us each, until nothing waits: identifier and first data byte.
    pub fn drain(&mut self) -> Vec<(u16, u8)> {
        let mut sent = Vec::new();
        while let Some(frame) = self.begin() {
            sent.push((raw_id(&frame), frame.data[0]));
            self.end(WireEvent::Transmitted);
        }
        sent
    }

    /// A frame of a peer arrives at once.
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
