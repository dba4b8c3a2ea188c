//! What must hold in every run.

use std::collections::BTreeMap;
use std::rc::Rc;

use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState, NodeId, Scet};
use host_worlds::log::Happening;
use host_worlds::{Time, World};

use crate::craft::{CampaignSlave, Notes, profile};
use crate::kind::Kind;
use crate::outcome::Outcome;
use crate::reach;
use crate::script::Script;

/// What is left at the end must have held for this long.
const CALM: Time = Time::from_ms(3_000);
/// Of a frame that was on the wire when its bus was left.
const ON_THE_WIRE: Time = Time::from_ms(1);
/// From its making a command may wait for its bus as long as the profile allows, and for its bus task.
const SLACK: Time = Time::from_ms(5);
/// A reason of a kind is reported once.
const MOST_REASONS: usize = 8;

/// A slave as its own events show it.
#[derive(Clone, Copy, Default)]
struct Seen {
    state: Option<NmtState>,
    bus: Option<Bus>,
    last_value: u32,
    scet: Option<Scet>,
}

/// Follows a run.
pub struct Judge<'a> {
    script: &'a Script,
    notes: Rc<Notes>,
    /// When states changed.
    pub events: Vec<Time>,
    entries: usize,
    deeds: usize,
    frames: [usize; 2],
    slaves: BTreeMap<NodeId, Seen>,
    /// Where the master was from when on, and why it went there; `None` at power-on.
    stays: Vec<(Time, Bus, Option<SwitchCause>)>,
    switches: Vec<(Time, Bus, SwitchCause)>,
    violations: Vec<String>,
}

impl<'a> Judge<'a> {
    /// At the start of a run.
    pub fn new(script: &'a Script, notes: Rc<Notes>) -> Self {
        Judge {
            script,
            notes,
            events: Vec::new(),
            entries: 0,
            deeds: 0,
            frames: [0; 2],
            slaves: BTreeMap::new(),
            stays: Vec::new(),
            switches: Vec::new(),
            violations: Vec::new(),
        }
    }

    fn complain(&mut self, text: String) {
        if self.violations.len() < MOST_REASONS {
            self.violations.push(text);
        }
    }

    /// Looks at what is new.
    pub fn look(&mut self, world: &World) {
        self.read_log(world);
        self.read_deeds(world);
        self.read_frames(world);
        self.read_clocks(world);
    }

    fn read_log(&mut self, world: &World) {
        let log = world.log();
        for entry in &log[self.entries..] {
            let slave = self.slaves.entry(entry.node).or_default();
            let is_change = match entry.what {
                Happening::PowerOn | Happening::PowerOff => {
                    *slave = Seen { last_value: slave.last_value, ..Seen::default() };
                    if entry.node == NodeId::MASTER && entry.what == Happening::PowerOn {
                        self.stays.push((entry.at, profile(self.script.selective).bdefault, None));
                    }
                    true
                }
                Happening::Master(MasterEvent::BusSwitched { from, to, cause }) => {
                    self.stays.push((entry.at, to, Some(cause)));
                    self.switches.push((entry.at, from, cause));
                    true
                }
                Happening::Master(event) => !matches!(
                    event,
                    MasterEvent::Pdo { .. }
                        | MasterEvent::Frame { .. }
                        | MasterEvent::Synchronised { .. }
                        | MasterEvent::Time(_)
                        | MasterEvent::Step(_)
                        | MasterEvent::Written(_)
                        | MasterEvent::SyncSent { .. }
                ),
                Happening::Slave(event) => {
                    match event {
                        SlaveEvent::State(state) => slave.state = Some(state),
                        SlaveEvent::ActiveBus { bus, .. } => slave.bus = Some(bus),
                        // It was set, so it may be earlier.
                        SlaveEvent::Step(_) => slave.scet = None,
                        _ => {}
                    }
                    !matches!(
                        event,
                        SlaveEvent::Pdo { .. }
                            | SlaveEvent::Synchronised { .. }
                            | SlaveEvent::Heartbeat { .. }
                            | SlaveEvent::Sync { .. }
                            | SlaveEvent::Time(_)
                            | SlaveEvent::Step(_)
                            | SlaveEvent::Written(_)
                    )
                }
            };
            if is_change {
                self.events.push(entry.at);
            }
        }
        self.entries = log.len();
    }

    /// Each command is executed once, and none that is older than its lifetime.
    fn read_deeds(&mut self, world: &World) {
        let notes = self.notes.clone();
        let deeds = notes.deeds.borrow();
        let clock = world.clock(NodeId::MASTER);
        let lifetime = Time::from_us(profile(self.script.selective).event.as_micros()) + SLACK;
        for deed in &deeds[self.deeds..] {
            let seen = self.slaves.entry(deed.node).or_default();
            let last = std::mem::replace(&mut seen.last_value, deed.value);
            let at = deed.at.as_us();
            if deed.value <= last {
                self.complain(format!(
                    "slave {} executed command {} after {last}, {at} us",
                    deed.node.get(),
                    deed.value
                ));
            }
            let made = notes.made(deed.value).zip(clock.as_ref()).map(|(made, clock)| clock.world_time(made));
            if let Some(made) = made.filter(|made| deed.at > *made + lifetime) {
                let age = deed.at.since(made).as_us();
                self.complain(format!("slave {} executed a command {age} us old, {at} us", deed.node.get()));
            }
        }
        self.deeds = deeds.len();
    }

    /// Nothing of the master goes out on a bus that it has left.
    fn read_frames(&mut self, world: &World) {
        for bus in Bus::ALL {
            let frames = world.frames(bus);
            for sent in &frames[std::mem::replace(&mut self.frames[bus as usize], frames.len())..] {
                let is_of_work = matches!(sent.id(), Some(0x000 | 0x080 | 0x181 | 0x301..=0x37F | 0x701));
                if sent.node != Some(NodeId::MASTER) || !is_of_work {
                    continue;
                }
                let (left, stays) = match self.stays.iter().rposition(|(from, ..)| *from <= sent.start) {
                    Some(index) => (self.stays[index].0, self.stays[index].1),
                    None => continue,
                };
                if stays != bus && sent.start > left + ON_THE_WIRE {
                    let id = sent.id().unwrap_or_default();
                    self.complain(format!(
                        "{id:03X}h of the master on {bus:?}, which it left, {} us",
                        sent.start.as_us()
                    ));
                }
            }
        }
    }

    /// No clock goes back, unless it was set.
    fn read_clocks(&mut self, world: &World) {
        for node in world.slaves() {
            if !world.is_powered(node) {
                continue;
            }
            let now = world.slave(node).with(|slave: &mut CampaignSlave, now| slave.scet(now));
            let seen = self.slaves.entry(node).or_default();
            if let Some(before) = seen.scet.replace(now)
                && now.is_before(before)
            {
                let at = world.now().as_us();
                self.complain(format!("the clock of slave {} went back, {at} us", node.get()));
            }
        }
    }

    /// At the end: the network works as well as what is left of it allows.
    pub fn finish(mut self, world: &World, effective: Vec<bool>) -> Outcome {
        if world.is_powered(NodeId::MASTER) {
            self.judge_network(world);
        }
        self.judge_innocence();
        let detections = self.detections();
        Outcome { violations: self.violations, effective, detections }
    }

    fn judge_network(&mut self, world: &World) {
        let here = world.master_bus();
        let alive = reach::alive(self.script);
        let reached = |bus| reach::reached(self.script, bus);
        let is_whole = |bus| reached(bus).len() == alive.len();
        let work = reached(here);
        for &node in &work {
            let Some(seen) = NodeId::new(node).and_then(|id| self.slaves.get(&id).copied()) else { continue };
            if seen.state != Some(NmtState::Operational) || seen.bus != Some(here) {
                self.complain(format!(
                    "slave {node} is {:?} on {:?}, the master on {here:?}",
                    seen.state, seen.bus
                ));
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
        let late = self.switches.iter().filter(|(at, ..)| *at > calm).count();
        if late > 0 && Bus::ALL.into_iter().any(is_whole) {
            self.complain(format!(
                "the master changed the bus {late} times in the last {} s",
                CALM.as_secs_f64()
            ));
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
