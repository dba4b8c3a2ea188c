//! State of the master boards of a run by their own events: one, or two of which one is the standby.

use can_twin::wire::time::Time;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, PerBus};
use ecss_can_worlds::NodeKey;
use ecss_can_worlds::judge::{Master, View};

use crate::campaign::nodes;
use crate::campaign::reach;
use crate::campaign::scene::{News, Noted};
use crate::campaign::script::Script;

/// Longest time in which frames of two masters that hear each other may collide. A controller that is bus-off receives
/// nothing.
const COLLISIONS: Time = Time::from_ms(20);

/// State of a board between two changes.
#[derive(Clone, Copy)]
pub struct Stay {
    /// Begin of the state.
    pub from: Time,
    /// Bus that it manages; `None` while it is not active.
    pub bus: Option<Bus>,
}

/// A change of the bus by an active master.
#[derive(Clone, Copy)]
pub struct Switch {
    pub at: Time,
    pub from: Bus,
    pub cause: SwitchCause,
}

/// A master board.
pub struct MasterBoard {
    pub key: NodeKey,
    /// Number of power-ons.
    pub lives: u32,
    pub stays: Vec<Stay>,
    pub switches: Vec<Switch>,
    /// Instants of changes of its role.
    pub roles: Vec<Time>,
    /// Changes of its controllers: instant, bus, and whether it is on the bus (false: bus-off).
    hearing: Vec<(Time, Bus, bool)>,
}

/// The master boards of a script.
pub struct Boards {
    all: Vec<MasterBoard>,
}

impl MasterBoard {
    /// Returns its name in violations.
    pub fn name(&self) -> &'static str {
        if self.key == NodeKey::SECOND_MASTER { "the second master" } else { "the master" }
    }

    /// Returns the bus that it manages now; `None` while it is not active.
    pub fn bus(&self) -> Option<Bus> {
        self.stays.last().and_then(|stay| stay.bus)
    }

    /// Returns its state at an instant; `None` before its power-on.
    pub fn at(&self, at: Time) -> Option<Stay> {
        self.stays.iter().rfind(|stay| stay.from <= at).copied()
    }

    /// Returns its role at an instant for the judge. A board without power manages no bus.
    fn seen_at(&self, at: Time) -> Master {
        let bus = self.at(at).and_then(|stay| stay.bus);
        Master { is_powered: true, bus, ..Master::default() }
    }

    /// Returns when the results of [`MasterBoard::at`] and [`MasterBoard::hears`] changed.
    fn changes(&self) -> impl Iterator<Item = Time> {
        self.stays.iter().map(|stay| stay.from).chain(self.hearing.iter().map(|(at, ..)| *at))
    }

    /// Records that both controllers are on their buses after a start.
    fn begins_to_hear(&mut self, at: Time) {
        self.hearing.extend(Bus::ALL.map(|bus| (at, bus, true)));
    }

    fn hears(&self, bus: Bus, at: Time) -> bool {
        let last = self.hearing.iter().rfind(|(since, of, _)| *of == bus && *since <= at);
        last.is_none_or(|(.., is_on)| *is_on)
    }

    fn read(&mut self, at: Time, news: News, is_one_of_two: bool) {
        let stay = |bus| Stay { from: at, bus };
        match news {
            News::PowerOn => {
                self.lives += 1;
                self.begins_to_hear(at);
                self.stays.push(stay(if is_one_of_two { None } else { Some(Bus::Nominal) }));
            }
            News::PowerOff if is_one_of_two => self.stays.push(stay(None)),
            News::Hearing { bus, is_on } => self.hearing.push((at, bus, is_on)),
            News::Role(bus) => {
                self.stays.push(stay(bus));
                self.roles.push(at);
                self.begins_to_hear(at);
            }
            News::Switched { from, to, cause } => {
                self.stays.push(stay(Some(to)));
                self.switches.push(Switch { at, from, cause });
            }
            _ => {}
        }
    }
}

impl Boards {
    /// Makes the boards of a script.
    pub fn new(script: &Script) -> Boards {
        let keys = [NodeKey::MASTER, NodeKey::SECOND_MASTER].into_iter().take(script.masters.into());
        let board = |key| MasterBoard {
            key,
            lives: 0,
            stays: Vec::new(),
            switches: Vec::new(),
            roles: Vec::new(),
            hearing: Vec::new(),
        };
        Boards { all: keys.map(board).collect() }
    }

    /// Reads a change. Changes of slaves are ignored.
    pub fn read(&mut self, noted: &Noted) {
        let is_one_of_two = self.all.len() > 1;
        if let Some(board) = self.all.iter_mut().find(|board| board.key == noted.key) {
            board.read(noted.at, noted.news, is_one_of_two);
        }
    }

    /// Returns all boards.
    pub fn iter(&self) -> impl Iterator<Item = &MasterBoard> {
        self.all.iter()
    }

    /// Returns the board of a key; `None` for a slave.
    pub fn of(&self, key: NodeKey) -> Option<&MasterBoard> {
        self.all.iter().find(|board| board.key == key)
    }

    /// Returns the interval in which two masters were active for too long although they heard each other. Each sends on
    /// both buses that it is active.
    pub fn meeting(&self, script: &Script) -> Option<(Time, Time)> {
        let [one, two] = self.all.as_slice() else { return None };
        let end = Time::from_us(script.length);
        // The state is constant between two of these instants.
        let boards = [one, two];
        let mut instants: Vec<Time> = boards.iter().flat_map(|board| board.changes()).collect();
        instants.extend(reach::changes(script));
        instants.retain(|at| *at < end);
        instants.sort();
        instants.dedup();
        let meet = |at| {
            let masters = boards.map(|board| board.seen_at(at));
            let hear = |bus| boards.iter().all(|board| board.hears(bus, at));
            let joins_masters =
                PerBus::from_fn(|bus| hear(bus) && reach::surely_joins_masters(script, bus, at));
            let view = View { masters: &masters, slaves: &[], joins_masters };
            Bus::ALL.into_iter().any(|bus| view.are_rivals_on(bus))
        };
        let longest = Time::from_us(nodes::bounds(script).rivalry.as_micros()) + COLLISIONS;
        let mut since = None;
        for (index, &at) in instants.iter().enumerate() {
            let until = instants.get(index + 1).copied().unwrap_or(end);
            since = if meet(at) { since.or(Some(at)) } else { None };
            if let Some(from) = since.filter(|from| until > *from + longest) {
                return Some((from, until));
            }
        }
        None
    }
}
