//! A node on a bench: frames and time in, what it wants done out.

use std::collections::HashMap;

use ecss_can::link::Stamp;
use ecss_can::link::port::{Filter, Health};
use ecss_can::node::extend::{BusCommand, LinkEvent, Outbox, Turn};
use ecss_can::node::{DeviceNode, FailCause, MasterEvent, Node, SlaveEvent};
use ecss_can::pdo::ReceivedPdo;
use ecss_can::types::{AbortCode, Address, Bus, CobId, Duration, Frame, Instant, NodeId};

/// The master of these tests.
pub type Master = ecss_can::node::Master<crate::console::Console>;

pub const NOMINAL: Bus = Bus::Nominal;
pub const REDUNDANT: Bus = Bus::Redundant;

pub fn ms(ms: u64) -> Instant {
    Instant::from_micros(ms * 1_000)
}

pub fn span(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

pub fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(CobId::new(id).unwrap(), data).unwrap()
}

pub fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}

/// An event that may be that of a receive PDO.
pub trait PdoEvent {
    fn pdo(&self) -> Option<&ReceivedPdo>;
}

impl PdoEvent for SlaveEvent {
    fn pdo(&self) -> Option<&ReceivedPdo> {
        if let SlaveEvent::Pdo(pdo) = self { Some(pdo) } else { None }
    }
}

impl PdoEvent for MasterEvent {
    fn pdo(&self) -> Option<&ReceivedPdo> {
        if let MasterEvent::Pdo(pdo) = self { Some(pdo) } else { None }
    }
}

/// Bus, number and payload of each event that is one of a receive PDO, `None` for the others.
pub fn pdos(events: &[impl PdoEvent]) -> Vec<Option<(Bus, u16, [u8; 8])>> {
    let told = |pdo: &ReceivedPdo| (pdo.bus(), pdo.number(), pdo.data);
    events.iter().map(|event| event.pdo().map(told)).collect()
}

pub fn stamp(at: Instant) -> Stamp {
    Stamp::interrupt(at)
}

fn is_question_for_errors(frame: &Frame) -> bool {
    (0x602..0x67F).contains(&frame.id().raw()) && frame.data() == [0x40, 0x01, 0x10, 0, 0, 0, 0, 0]
}

fn is_emergency(id: CobId) -> bool {
    (0x081..=0x0FF).contains(&id.raw())
}

/// A frame that a node sent: when, where, what, and until when it lives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sent {
    pub at: Instant,
    pub bus: Bus,
    pub frame: Frame,
    pub expires: Instant,
}

/// Runs a node from deadline to deadline and keeps everything it did.
pub struct Bench<N: Node> {
    pub node: N,
    pub now: Instant,
    pub sent: Vec<Sent>,
    /// Commands other than sending.
    pub controls: Vec<(Bus, BusCommand)>,
    /// Filters of both controllers.
    filters: HashMap<(Bus, u8), Filter>,
    pub events: Vec<N::Event>,
    /// Another node acknowledges emergencies, and boot-up messages of slaves.
    pub is_acknowledged: bool,
    /// Slaves answer the master that they have no errors (1001h), and neither question nor answer is kept.
    pub has_no_errors: bool,
}

impl<N: Node> Bench<N> {
    /// Powered on at zero.
    pub fn new(node: N) -> Self {
        Self::powered(Instant::ZERO, node, true)
    }

    /// Powered on at zero, without another node.
    pub fn alone(node: N) -> Self {
        Self::powered(Instant::ZERO, node, false)
    }

    /// Powered on later.
    pub fn powered_at(now: Instant, node: N) -> Self {
        Self::powered(now, node, true)
    }

    fn powered(now: Instant, node: N, is_acknowledged: bool) -> Self {
        let filters = node.filters();
        let filters = Bus::ALL
            .into_iter()
            .flat_map(|bus| (0..).zip(&filters).map(move |(number, filter)| ((bus, number), *filter)))
            .collect();
        let mut bench = Bench {
            node,
            now,
            sent: vec![],
            controls: vec![],
            filters,
            events: vec![],
            is_acknowledged,
            has_no_errors: true,
        };
        bench.with(|node, turn| node.start(turn));
        bench
    }

    /// The application does something, and the node then what is due.
    pub fn touch<R>(&mut self, touch: impl FnOnce(&mut N, Instant) -> R) -> R {
        let result = touch(&mut self.node, self.now);
        self.with(|node, turn| node.poll(turn));
        result
    }

    /// The application writes an object.
    pub fn write(&mut self, at: (u16, u8), value: &[u8]) -> Result<(), AbortCode>
    where
        N: DeviceNode,
    {
        let mut written = Ok(());
        self.with(|node, turn| written = node.write(Address::new(at.0, at.1), value, turn));
        written
    }

    fn with(&mut self, step: impl FnOnce(&mut N, &mut Turn<'_, N::Event, N::Depth>)) {
        let mut out = Outbox::new();
        let (mut acknowledged, mut asked) = (Vec::new(), Vec::new());
        step(&mut self.node, &mut Turn::new(self.now, &mut out));
        while let Some((bus, command)) = out.pop_command() {
            match command {
                BusCommand::Send(outgoing)
                    if !self.node.charge(&outgoing.frame, &mut Turn::new(self.now, &mut out)) =>
                {
                    let event = LinkEvent::Failed { frame: outgoing.frame, cause: FailCause::OverBudget };
                    self.node.on_link(bus, &event, &mut Turn::new(self.now, &mut out));
                }
                BusCommand::Send(outgoing) => {
                    let (frame, expires) = (outgoing.frame, outgoing.expires);
                    if self.has_no_errors && is_question_for_errors(&frame) {
                        asked.push((bus, frame.id().raw() - 0x080));
                        continue;
                    }
                    self.sent.push(Sent { at: self.now, bus, frame, expires });
                    let is_boot_up = frame.id().raw() > 0x701 && frame.data() == [0];
                    if self.is_acknowledged && (is_boot_up || is_emergency(frame.id())) {
                        acknowledged.push((bus, frame));
                    }
                }
                // A filter that is what it was is no news: nodes send each again from time to time.
                BusCommand::Filter { number, filter }
                    if self.filters.insert((bus, number), filter).is_none_or(|before| before == filter) => {}
                other => self.controls.push((bus, other)),
            }
        }
        while let Some(event) = out.pop_event() {
            self.events.push(event);
        }
        assert_eq!(out.take_overflows(), 0);
        for (bus, frame) in acknowledged {
            self.transmitted(bus, frame);
        }
        for (bus, answer) in asked {
            self.receive(bus, answer, &[0x4F, 0x01, 0x10, 0, 0, 0, 0, 0]);
        }
    }

    /// Let time pass: polls at every deadline up to and including `until`.
    pub fn run_until(&mut self, until: Instant) {
        while let Some(deadline) = self.node.deadline().filter(|deadline| *deadline <= until) {
            assert!(deadline >= self.now, "a deadline of the past is not served");
            self.now = deadline;
            self.settle();
        }
        self.now = until;
    }

    /// Lets a save run to its end: slice by slice, 100 us apart.
    pub fn finish_save(&mut self) {
        self.settle();
        while let Some(next) = self.node.deadline().filter(|next| next.since(self.now).as_micros() <= 100) {
            self.now = next;
            self.settle();
        }
    }

    /// Polls until nothing is due any more.
    pub fn settle(&mut self) {
        for _ in 0..20_000 {
            self.with(|node, turn| node.poll(turn));
            if self.node.deadline().is_none_or(|next| next > self.now) {
                return;
            }
        }
        panic!("a deadline that stays is a busy loop");
    }

    pub fn link(&mut self, bus: Bus, event: LinkEvent) {
        self.with(|node, turn| node.on_link(bus, &event, turn));
        self.check_deadline();
    }

    /// A node does at once what an event makes due: before its deadline it has nothing to do. A changed filter may be
    /// set earlier.
    fn check_deadline(&mut self) {
        let due = self.node.deadline().unwrap_or(Instant::NEVER);
        if due <= self.now {
            return;
        }
        let before = (self.sent.len(), self.events.len(), self.controls.len());
        self.with(|node, turn| node.poll(turn));
        let is_filter = |control: &(Bus, BusCommand)| matches!(control.1, BusCommand::Filter { .. });
        assert!(self.controls[before.2..].iter().all(is_filter), "done before the deadline");
        assert_eq!((self.sent.len(), self.events.len()), (before.0, before.1), "done before the deadline");
        assert!(self.node.deadline().is_none_or(|next| next >= due), "the deadline was too late");
    }

    /// A frame ends now.
    pub fn receive(&mut self, bus: Bus, id: u16, data: &[u8]) {
        let stamp = stamp(self.now);
        self.link(bus, LinkEvent::Received { frame: frame(id, data), stamp });
    }

    pub fn transmitted(&mut self, bus: Bus, frame: Frame) {
        let stamp = stamp(self.now);
        self.link(bus, LinkEvent::Transmitted { frame, stamp });
    }

    pub fn failed(&mut self, bus: Bus, frame: Frame, cause: FailCause) {
        self.link(bus, LinkEvent::Failed { frame, cause });
    }

    pub fn health(&mut self, bus: Bus, health: Health) {
        self.link(bus, LinkEvent::Health(health));
    }

    pub fn request(&mut self, request: N::Request) {
        self.with(|node, turn| node.on_request(request, turn));
    }

    /// Returns whether a filter of the controller of this bus admits frames with this COB-ID.
    pub fn admits(&self, bus: Bus, id: u16) -> bool {
        let id = CobId::new(id).unwrap();
        self.filters.iter().any(|((of, _), filter)| *of == bus && filter.admits(id))
    }

    /// Forget what was done so far.
    pub fn clear(&mut self) {
        self.sent.clear();
        self.controls.clear();
        self.clear_events();
    }

    /// Forget the events so far.
    pub fn clear_events(&mut self) {
        self.events.clear();
    }

    /// What was sent so far, as bus and frame.
    pub fn frames(&self) -> Vec<(Bus, Frame)> {
        self.sent.iter().map(|sent| (sent.bus, sent.frame)).collect()
    }

    /// When frames of this COB-ID were sent on this bus, milliseconds.
    pub fn times(&self, bus: Bus, id: u16) -> Vec<u64> {
        let of_id = self.sent.iter().filter(|sent| sent.bus == bus && sent.frame.id().raw() == id);
        of_id.map(|sent| sent.at.as_micros() / 1_000).collect()
    }
}
