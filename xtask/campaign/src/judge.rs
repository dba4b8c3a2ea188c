//! What must hold in every run.

use std::collections::BTreeMap;

use can_wire::time::Time;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState, NodeId, PerBus, Scet};

use crate::kind::Kind;
use crate::outcome::Outcome;
use crate::reach;
use crate::scene::{News, Noted, Scene, Seen, Sent};
use crate::script::Script;

/// What is left at the end must have held for this long.
const CALM: Time = Time::from_ms(3_000);
/// Of a frame that was on the wire when its bus was left.
const ON_THE_WIRE: Time = Time::from_ms(1);
/// A master that is isolated had no acknowledgement for 2 ms; the tolerance is that of stamps.
const ISOLATION: Time = Time::from_us(1_900);
/// A reading of a clock may be from before it was set, and seen after.
const STALE_READING: Time = Time::from_ms(150);
/// A reason of a kind is reported once.
const MOST_REASONS: usize = 8;

/// A slave as its own events show it.
#[derive(Clone, Copy, Default)]
struct Slave {
    state: Option<NmtState>,
    bus: Option<Bus>,
    scet: Option<Scet>,
    /// When its clock was set.
    set: Option<Time>,
}

/// Follows a run.
pub struct Judge<'a> {
    script: &'a Script,
    news: usize,
    frames: PerBus<usize>,
    slaves: BTreeMap<NodeId, Slave>,
    /// Where the master was from when on, and why it went there; `None` at power-on.
    stays: Vec<(Time, Bus, Option<SwitchCause>)>,
    switches: Vec<(Time, Bus, SwitchCause)>,
    /// Nodes that reported another one with their Node-ID.
    collisions: Vec<NodeId>,
    violations: Vec<String>,
}

impl<'a> Judge<'a> {
    /// At the start of a run.
    pub fn new(script: &'a Script) -> Self {
        Judge {
            script,
            news: 0,
            frames: PerBus::default(),
            slaves: BTreeMap::new(),
            stays: Vec::new(),
            switches: Vec::new(),
            collisions: Vec::new(),
            violations: Vec::new(),
        }
    }

    fn complain(&mut self, text: String) {
        if self.violations.len() < MOST_REASONS {
            self.violations.push(text);
        }
    }

    /// Looks at what is new.
    pub fn look(&mut self, scene: &mut impl Scene, seen: &Seen) {
        self.read_news(seen);
        self.read_frames(seen);
        self.read_clocks(scene);
        scene.take_wrongs().into_iter().for_each(|wrong| self.complain(wrong));
    }

    fn read_news(&mut self, seen: &Seen) {
        for &Noted { at, node, news } in &seen.news[std::mem::replace(&mut self.news, seen.news.len())..] {
            let slave = self.slaves.entry(node).or_default();
            match news {
                News::PowerOn | News::PowerOff => {
                    *slave = Slave::default();
                    if node == NodeId::MASTER && news == News::PowerOn {
                        self.stays.push((at, Bus::Nominal, None));
                    }
                }
                News::Switched { from, to, cause } => {
                    self.stays.push((at, to, Some(cause)));
                    self.switches.push((at, from, cause));
                    if cause == SwitchCause::Isolated {
                        self.judge_isolation(at, &seen.frames[from]);
                    }
                }
                News::State(state) => slave.state = Some(state),
                News::ActiveBus(bus) => slave.bus = Some(bus),
                // It may be earlier.
                News::ClockSet => (slave.scet, slave.set) = (None, Some(at)),
                News::Collision => self.collisions.push(node),
                News::Other => {}
            }
        }
    }

    /// A master that leaves a bus as isolated was not acknowledged there just before.
    fn judge_isolation(&mut self, at: Time, frames: &[Sent]) {
        let heard = frames.iter().rev().find(|sent| sent.end <= at && sent.end + ISOLATION > at);
        if let Some(heard) = heard.filter(|sent| sent.node == Some(NodeId::MASTER)) {
            let (since, at) = (at.since(heard.end).as_us(), at.as_us());
            self.complain(format!("the master was isolated {since} us after an acknowledged frame, {at} us"));
        }
    }

    /// Nothing of the master goes out on a bus that it has left.
    fn read_frames(&mut self, seen: &Seen) {
        for bus in Bus::ALL {
            let frames = &seen.frames[bus];
            for sent in &frames[std::mem::replace(&mut self.frames[bus], frames.len())..] {
                if self.is_babbled(bus, sent) {
                    continue;
                }
                let is_of_work = matches!(sent.id, Some(0x000 | 0x080 | 0x181 | 0x301..=0x37F | 0x701));
                if sent.node != Some(NodeId::MASTER) || !is_of_work {
                    continue;
                }
                let (left, stays) = match self.stays.iter().rposition(|(from, ..)| *from <= sent.start) {
                    Some(index) => (self.stays[index].0, self.stays[index].1),
                    None => continue,
                };
                if stays != bus && sent.start > left + ON_THE_WIRE {
                    let id = sent.id.unwrap_or_default();
                    self.complain(format!(
                        "{id:03X}h of the master on {bus:?}, which it left, {} us",
                        sent.start.as_us()
                    ));
                }
            }
        }
    }

    /// Whether a frame of the master is a fault of the script: what babbles is its controller.
    fn is_babbled(&self, bus: Bus, sent: &Sent) -> bool {
        self.script.faults.iter().any(|fault| {
            fault.kind == Kind::Babble
                && fault.bus == bus
                && fault.node == 1
                && sent.id == Some(fault.value as u16)
        })
    }

    /// No clock goes back, unless it was set.
    fn read_clocks(&mut self, scene: &mut impl Scene) {
        for reading in scene.take_clocks() {
            let slave = self.slaves.entry(reading.node).or_default();
            if slave.set.is_some_and(|set| reading.at < set + STALE_READING) {
                continue;
            }
            if slave.scet.replace(reading.scet).is_some_and(|before| reading.scet.is_before(before)) {
                let (node, at) = (reading.node.get(), reading.at.as_us());
                self.complain(format!("the clock of slave {node} went back, {at} us"));
            }
        }
    }

    /// At the end: the network works as well as what is left of it allows.
    pub fn finish(mut self, scene: &mut impl Scene, seen: &Seen, effective: Vec<bool>) -> Outcome {
        self.look(scene, seen);
        if scene.is_powered(NodeId::MASTER) {
            self.judge_network(scene);
        }
        self.judge_innocence();
        self.judge_collisions(&effective);
        let detections = self.detections();
        Outcome { violations: self.violations, effective, detections }
    }

    /// The bus of the master.
    fn master_bus(&self) -> Bus {
        self.stays.last().map_or(Bus::Nominal, |(_, bus, _)| *bus)
    }

    fn judge_network(&mut self, scene: &impl Scene) {
        let here = self.master_bus();
        let alive = reach::alive(self.script);
        let reached = |bus| reach::reached(self.script, bus);
        let is_whole = |bus| reached(bus).len() == alive.len();
        let work: Vec<NodeId> = reached(here).into_iter().filter_map(NodeId::new).collect();
        let unconfigured = scene.unconfigured();
        for &node in &work {
            let Slave { state, bus, .. } = self.slaves.get(&node).copied().unwrap_or_default();
            let (slave, bdefault) = (node.get(), scene.bdefault(node));
            if state != Some(NmtState::Operational) || bus != Some(here) {
                self.complain(format!("slave {slave} is {state:?} on {bus:?}, the master on {here:?}"));
            } else if bdefault.is_some_and(|bus| bus != here) {
                self.complain(format!("Bdefault of slave {slave} is {bdefault:?}, its master on {here:?}"));
            } else if unconfigured.contains(&node) {
                self.complain(format!("slave {slave} is operational without its configuration"));
            }
        }
        // A master that was restarted has forgotten slaves that are not assigned. It cannot ask them on the other bus, so they
        // do not count (docs/decisions/who-counts.md).
        let is_first_life = self.stays.iter().filter(|(.., cause)| cause.is_none()).count() <= 1;
        if is_first_life && !is_whole(here) && is_whole(here.other()) {
            self.complain(format!("the master is on {here:?}, all slaves are reached on the other bus"));
        }
        if work.is_empty() {
            // It alternates; with somebody there it would stay.
            if Bus::ALL.into_iter().any(|bus| !reached(bus).is_empty()) {
                self.complain(format!("the master is on {here:?}, slaves are reached on the other bus only"));
            }
            return;
        }
        let calm = Time::from_us(self.script.length).since(CALM);
        // Bit errors that stay may make a bus bad at any time: on an idle bus each one begins a frame that nobody sends, so nodes
        // are error passive every now and then. Such a node cannot destroy a frame that it alone has wrong. When the sender is
        // acknowledged by another node, the frame is lost to it, and two heartbeats in a row are more than the consumer time.
        let is_noisy = |bus| {
            let mut faults = self.script.faults.iter();
            faults.any(|fault| fault.kind == Kind::Noise && fault.lasts.is_none() && fault.bus == bus)
        };
        let late = self.switches.iter().find(|(at, from, _)| *at > calm && !is_noisy(*from)).copied();
        if let Some((at, from, cause)) = late.filter(|_| Bus::ALL.into_iter().any(is_whole)) {
            let (calm, at) = (CALM.as_secs_f64(), at.as_us());
            self.complain(format!("the master left {from:?} ({cause:?}) in the last {calm} s, {at} us"));
        }
    }

    /// What a network must not even notice moves nobody.
    fn judge_innocence(&mut self) {
        let harmless = |kind| matches!(kind, Kind::Stranger | Kind::Flip);
        if self.script.faults.iter().all(|fault| harmless(fault.kind)) && !self.switches.is_empty() {
            let (at, from, cause) = self.switches[0];
            let at = at.as_us();
            self.complain(format!(
                "the master left {from:?} ({cause:?}) for a fault that hurts nobody, {at} us"
            ));
        }
    }

    /// A node whose Node-ID somebody else uses on a whole bus reports it.
    fn judge_collisions(&mut self, effective: &[bool]) {
        let [fault] = self.script.faults.as_slice() else { return };
        let is_collision = matches!(fault.kind, Kind::Clash | Kind::ForeignMaster) && effective == [true];
        let is_deaf = self.script.selective && fault.node == 4 && fault.bus != Bus::Nominal;
        let is_reported = self.collisions.iter().any(|node| node.get() == fault.node);
        if is_collision && !is_deaf && !is_reported {
            self.complain(format!("node {} did not report another one with its Node-ID", fault.node));
        }
    }

    /// From the last fault on a bus to its leaving.
    fn detections(&self) -> Vec<u64> {
        let faults = self.script.faults.iter();
        let onset = |at: Time, bus: Bus| {
            let here = faults
                .clone()
                .filter(|fault| fault.bus == bus && fault.kind.lasts() && !fault.kind.is_of_node());
            here.map(|fault| Time::from_us(fault.at)).filter(|from| *from <= at).max()
        };
        let counts =
            |cause| matches!(cause, SwitchCause::Isolated | SwitchCause::SlavesSilent | SwitchCause::BusOff);
        let switches = self.switches.iter().filter(|(.., cause)| counts(*cause));
        switches.filter_map(|&(at, bus, _)| onset(at, bus).map(|from| at.since(from).as_us())).collect()
    }
}
