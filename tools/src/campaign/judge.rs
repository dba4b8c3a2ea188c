//! Conditions that must hold in every run.

use std::collections::BTreeMap;

use can_twin::wire::time::Time;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState, NodeId, PerBus, Scet};
use ecss_can_worlds::NodeKey;
use ecss_can_worlds::judge::{Master, View};

use crate::campaign::boards::{Boards, MasterBoard, Stay, Switch};
use crate::campaign::kind::Kind;
use crate::campaign::outcome::Outcome;
use crate::campaign::reach;
use crate::campaign::scene::{News, Noted, Scene, Seen, Sent};
use crate::campaign::script::{Fault, SELECTIVE, Script};

/// Time for which the final state must have been stable.
const CALM: Time = Time::from_ms(3_000);
/// Tolerance for a frame that was on the wire when its bus was left.
const ON_THE_WIRE: Time = Time::from_ms(1);
/// Delay within which a board logs a change; it may send in between.
const LOGGED_WITHIN: Time = Time::from_ms(2);
/// An isolated master had no acknowledgement for 2 ms, minus the tolerance of stamps.
const ISOLATION: Time = Time::from_us(1_900);
/// Time for which a reading may be from before the clock was set.
const STALE_READING: Time = Time::from_ms(150);
/// Greatest number of reported reasons.
const MOST_REASONS: usize = 8;

/// State of a slave by its own events.
#[derive(Clone, Copy, Default)]
struct Slave {
    state: Option<NmtState>,
    bus: Option<Bus>,
    scet: Option<Scet>,
    /// Instant at which its clock was set or restarted.
    set: Option<Time>,
}

/// Judge of a run.
pub struct Judge<'a> {
    script: &'a Script,
    news: usize,
    frames: PerBus<usize>,
    slaves: BTreeMap<NodeId, Slave>,
    /// Slaves in the order of a view.
    nodes: Vec<NodeId>,
    boards: Boards,
    /// Nodes that reported another one with their Node-ID.
    collisions: Vec<NodeId>,
    violations: Vec<String>,
}

impl<'a> Judge<'a> {
    /// Makes the judge at the start of a run.
    pub fn new(script: &'a Script) -> Self {
        Judge {
            script,
            news: 0,
            frames: PerBus::default(),
            slaves: BTreeMap::new(),
            nodes: script.nodes().collect(),
            boards: Boards::new(script),
            collisions: Vec::new(),
            violations: Vec::new(),
        }
    }

    /// Returns the end of the run.
    fn end(&self) -> Time {
        Time::from_us(self.script.length)
    }

    fn complain(&mut self, text: String) {
        if self.violations.len() < MOST_REASONS {
            self.violations.push(text);
        }
    }

    /// Checks the new changes and frames.
    pub fn look(&mut self, scene: &mut impl Scene, seen: &Seen) {
        self.read_news(seen);
        self.read_frames(seen, scene.now());
        self.read_clocks(scene);
        scene.take_wrongs().into_iter().for_each(|wrong| self.complain(wrong));
    }

    fn read_news(&mut self, seen: &Seen) {
        for noted in &seen.news[std::mem::replace(&mut self.news, seen.news.len())..] {
            let Noted { at, key, news } = *noted;
            let node = key.node();
            self.boards.read(noted);
            let slave = self.slaves.entry(node).or_default();
            match news {
                // Its clock restarts.
                News::PowerOn | News::PowerOff => *slave = Slave { set: Some(at), ..Slave::default() },
                News::Switched { from, cause: SwitchCause::Isolated, .. } => {
                    self.judge_isolation(at, key, &seen.frames[from]);
                }
                News::Switched { .. } | News::Role(_) | News::Hearing { .. } => {}
                News::State(state) => slave.state = Some(state),
                News::ActiveBus(bus) => slave.bus = Some(bus),
                // The new time may be earlier.
                News::ClockSet => (slave.scet, slave.set) = (None, Some(at)),
                News::Collision => self.collisions.push(node),
                News::Other => {}
            }
        }
    }

    /// Checks that a master that leaves a bus as isolated was not acknowledged there just before.
    fn judge_isolation(&mut self, at: Time, master: NodeKey, frames: &[Sent]) {
        let heard = frames.iter().rev().find(|sent| sent.end <= at && sent.end + ISOLATION > at);
        if let Some(heard) = heard.filter(|sent| sent.key == Some(master)) {
            let (since, at) = (at.since(heard.end).as_us(), at.as_us());
            self.complain(format!("the master was isolated {since} us after an acknowledged frame, {at} us"));
        }
    }

    /// Checks that a master sends nothing on a bus that it has left, and nothing at all while it is not active. Frames
    /// are judged only after later log entries were read.
    fn read_frames(&mut self, seen: &Seen, now: Time) {
        for bus in Bus::ALL {
            let frames = &seen.frames[bus][self.frames[bus]..];
            let is_judged = |sent: &&Sent| sent.start + LOGGED_WITHIN < now || now >= self.end();
            let frames = &frames[..frames.iter().take_while(is_judged).count()];
            self.frames[bus] += frames.len();
            for sent in frames {
                if self.is_babbled(bus, sent) {
                    continue;
                }
                let is_of_work = matches!(sent.id, Some(0x000 | 0x080 | 0x181 | 0x301..=0x37F | 0x701));
                let Some(board) = sent.key.and_then(|key| self.boards.of(key)) else { continue };
                let is_out_of_place = |stay: Stay| stay.bus.is_none_or(|here| is_of_work && here != bus);
                let Some(stay) = board.at(sent.start) else { continue };
                let next = board.at(sent.start + LOGGED_WITHIN).unwrap_or(stay);
                if is_out_of_place(stay) && is_out_of_place(next) && sent.start > stay.from + ON_THE_WIRE {
                    let (id, name, at) = (sent.id.unwrap_or_default(), board.name(), sent.start.as_us());
                    let why = if stay.bus.is_some() { "which it left" } else { "while it is not active" };
                    self.complain(format!("{id:03X}h of {name} on {bus:?}, {why}, {at} us"));
                }
            }
        }
    }

    /// Returns whether a frame of the master is a fault of the script: its controller babbles.
    fn is_babbled(&self, bus: Bus, sent: &Sent) -> bool {
        self.script.faults.iter().any(|fault| {
            fault.kind == Kind::Babble
                && fault.bus == bus
                && fault.key() == sent.key
                && sent.id == Some(fault.value as u16)
        })
    }

    /// Checks that no clock goes back unless it was set.
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

    /// Judges the end of the run: the network must work as well as the remaining faults allow.
    pub fn finish(mut self, scene: &mut impl Scene, seen: &Seen, effective: Vec<bool>) -> Outcome {
        self.look(scene, seen);
        let (masters, slaves) = (self.masters(scene), self.slaves(scene));
        let joins_masters = PerBus::from_fn(|bus| reach::joins_masters(self.script, bus));
        let view = View { masters: &masters, slaves: &slaves, joins_masters };
        self.judge_pair(&view);
        let unconfigured = scene.unconfigured();
        view.active().for_each(|(master, here)| self.judge_network(&view, master, here, &unconfigured));
        if !Bus::ALL.into_iter().any(|bus| self.is_noisy(bus)) {
            self.judge_errors(&view, &scene.unknown_errors());
        }
        self.judge_innocence();
        self.judge_collisions(&effective);
        let detections = self.detections();
        Outcome { violations: self.violations, effective, detections }
    }

    /// Returns the master boards. A change of the bus in the last seconds counts, but not from a bus with bit errors.
    fn masters(&self, scene: &impl Scene) -> Vec<Master> {
        let master = |board: &MasterBoard| Master {
            is_powered: scene.is_powered(board.key),
            bus: board.bus(),
            has_switched: self.late_switch(board).is_some(),
            ..Master::default()
        };
        self.boards.iter().map(master).collect()
    }

    /// Returns the slaves by the wires and their own events.
    fn slaves(&self, scene: &impl Scene) -> Vec<ecss_can_worlds::judge::Slave> {
        let mut slaves = reach::slaves(self.script);
        for (slave, node) in slaves.iter_mut().zip(&self.nodes) {
            let shown = self.shown(*node);
            slave.state = shown.state.unwrap_or(NmtState::Initialising);
            slave.bus = shown.bus;
            slave.parameters = scene.parameters(*node);
        }
        slaves
    }

    fn shown(&self, node: NodeId) -> Slave {
        self.slaves.get(&node).copied().unwrap_or_default()
    }

    fn late_switch(&self, board: &MasterBoard) -> Option<Switch> {
        let calm = self.end().since(CALM);
        board.switches.iter().find(|switch| switch.at > calm && !self.is_noisy(switch.from)).copied()
    }

    /// Checks that one of two masters is active, or both if no bus joins them.
    fn judge_pair(&mut self, view: &View) {
        let (powered, active) = (view.powered().count(), view.active().count());
        let expected = view.managers_expected();
        if active != expected {
            self.complain(format!("{active} of {powered} masters are active, expected {expected}"));
        }
        if let Some((from, until)) = self.boards.meeting(self.script) {
            let (from, until) = (from.as_us(), until.as_us());
            self.complain(format!("two masters that hear each other are active, {from} to {until} us"));
        }
        let calm = self.end().since(CALM);
        let late = self.boards.iter().find_map(|board| {
            let at = board.roles.last().filter(|at| **at > calm)?;
            Some((board.name(), *at))
        });
        let is_noisy = Bus::ALL.into_iter().any(|bus| self.is_noisy(bus));
        if let Some((name, at)) = late.filter(|_| !is_noisy) {
            let (calm, at) = (CALM.as_secs_f64(), at.as_us());
            self.complain(format!("{name} changed its role in the last {calm} s, {at} us"));
        }
    }

    /// Returns whether a bus has permanent bit errors, which may disturb it at any time. On an idle bus each error
    /// looks like a start of frame, so nodes are error passive now and then. Such a node cannot destroy a frame that
    /// only it received with an error. If another node acknowledges, the frame is lost for it, and two lost heartbeats
    /// in a row exceed the consumer time.
    fn is_noisy(&self, bus: Bus) -> bool {
        let mut faults = self.script.faults.iter();
        faults.any(|fault| fault.kind == Kind::Noise && fault.lasts.is_none() && fault.bus == bus)
    }

    /// Returns whether a foreign node imitates the master until the end on the bus that the master has left, where only
    /// a slave with selective access receives it. The slave has no reason to search on the other bus.
    fn is_deceived(&self, node: NodeId, here: Bus) -> bool {
        let to_the_end =
            |fault: &Fault| fault.end().is_some_and(|end| Time::from_us(end) + CALM > self.end());
        let mut faults = self.script.faults.iter();
        let is_selective = self.script.selective && node == SELECTIVE;
        is_selective
            && faults.any(|fault| fault.kind == Kind::ForeignMaster && fault.bus != here && to_the_end(fault))
    }

    /// Judges an active master on its bus, and the slaves that it has to serve.
    fn judge_network(&mut self, view: &View, master: usize, here: Bus, unconfigured: &[NodeId]) {
        for index in view.to_serve(master) {
            let node = self.nodes[index];
            let (slave, Slave { state, bus, .. }) = (node.get(), self.shown(node));
            if self.is_deceived(node, here) {
                continue;
            }
            if !view.serves(master, index) {
                self.complain(format!("slave {slave} is {state:?} on {bus:?}, the master on {here:?}"));
            } else if let wrong @ Some(_) = view.wrong_bdefault(master, index) {
                self.complain(format!("Bdefault of slave {slave} is {wrong:?}, its master on {here:?}"));
            } else if unconfigured.contains(&node) {
                self.complain(format!("slave {slave} is operational without its configuration"));
            }
        }
        if (0..view.slaves.len()).any(|slave| view.is_contested(master, slave)) {
            return;
        }
        let Some(board) = self.boards.iter().nth(master) else { return };
        let late = self.late_switch(board).filter(|_| view.has_moved(master) && !view.is_split(master));
        // A restarted master does not know slaves that are not assigned. It cannot query them on the other bus, so they
        // do not count (docs/decisions/master-bus-choice.md).
        let is_first_life = board.lives <= 1;
        // After a split a master may stay on a bus with some of the slaves, even if the other bus reaches all again
        // (docs/decisions/master-bus-choice.md).
        let is_known = is_first_life && !reach::was_split(self.script, master);
        if is_known && !view.serves_all(master, here) && view.serves_all(master, here.other()) {
            self.complain(format!("the master is on {here:?}, all slaves are reached on the other bus"));
        }
        if view.to_serve(master).next().is_none() {
            // The master alternates; it would stay on a bus with a slave.
            if view.has_slaves(master) {
                self.complain(format!("the master is on {here:?}, slaves are reached on the other bus only"));
            }
            return;
        }
        if let Some(Switch { at, from, cause }) = late {
            let (calm, at) = (CALM.as_secs_f64(), at.as_us());
            self.complain(format!("the master left {from:?} ({cause:?}) in the last {calm} s, {at} us"));
        }
    }

    /// Checks that an active master knows the active errors of the slaves that it serves, and no others.
    fn judge_errors(&mut self, view: &View, unknown: &[(NodeId, NodeKey, String)]) {
        for (master, _) in view.active() {
            let Some(key) = self.boards.iter().nth(master).map(|board| board.key) else { continue };
            for index in view.to_serve(master).filter(|index| view.serves(master, *index)) {
                let node = self.nodes[index];
                for (_, _, what) in unknown.iter().filter(|(slave, of, _)| (*slave, *of) == (node, key)) {
                    self.complain(format!("slave {}: {what}", node.get()));
                }
            }
        }
    }

    /// Checks that harmless faults cause no change of the bus or of a role.
    fn judge_innocence(&mut self) {
        let harmless = |kind| matches!(kind, Kind::UnknownNode | Kind::Flip);
        let Some(first) = self.script.faults.first() else { return };
        if !self.script.faults.iter().all(|fault| harmless(fault.kind)) {
            return;
        }
        let moved = self.boards.iter().find_map(|board| board.switches.first()).copied();
        if let Some(Switch { at, from, cause }) = moved {
            let at = at.as_us();
            self.complain(format!(
                "the master left {from:?} ({cause:?}) for a fault that hurts nobody, {at} us"
            ));
        }
        let begun = Time::from_us(first.at);
        let changed = self.boards.iter().flat_map(|board| &board.roles).find(|at| **at > begun).copied();
        if let Some(at) = changed {
            let at = at.as_us();
            self.complain(format!("a master changed its role for a fault that hurts nobody, {at} us"));
        }
    }

    /// Checks that a node reports another node with its Node-ID on an undamaged bus.
    fn judge_collisions(&mut self, effective: &[bool]) {
        let [fault] = self.script.faults.as_slice() else { return };
        let is_collision = matches!(fault.kind, Kind::Clash | Kind::ForeignMaster) && effective == [true];
        let is_deaf = self.script.selective && fault.node == SELECTIVE.get() && fault.bus != Bus::Nominal;
        let is_reported = self.collisions.iter().any(|node| node.get() == fault.node);
        if is_collision && !is_deaf && !is_reported {
            self.complain(format!("node {} did not report another one with its Node-ID", fault.node));
        }
    }

    /// Returns the times from the last fault on a bus until the master left it.
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
        let switches = self.boards.iter().flat_map(|board| &board.switches);
        let late = |switch: &Switch| Some(switch.at.since(onset(switch.at, switch.from)?).as_us());
        switches.filter(|switch| counts(switch.cause)).filter_map(late).collect()
    }
}
