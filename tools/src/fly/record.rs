//! Records of a flight for the observers of the demo.
//!
//! Narrator, observer, logs and report use only these records, in chronological order.

pub use can_twin::rtt::Level;
pub use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;

use super::meaning::{Meaning, Scope};
pub use crate::images::support::node::{MASTER, Node, SECOND_MASTER, is_master};

/// A set of boards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Nodes(u128);

impl Nodes {
    /// Adds a board.
    pub fn insert(&mut self, node: Node) {
        self.0 |= 1 << node;
    }

    /// Returns whether `node` is in it.
    pub fn contains(self, node: Node) -> bool {
        self.0 & 1 << node != 0
    }
}

impl FromIterator<Node> for Nodes {
    fn from_iter<I: IntoIterator<Item = Node>>(nodes: I) -> Self {
        let mut set = Nodes::default();
        nodes.into_iter().for_each(|node| set.insert(node));
        set
    }
}

/// A frame that completed on a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seen {
    /// The bus.
    pub bus: Bus,
    /// The frame.
    pub frame: WireFrame,
    /// Its meaning, if it has one.
    pub meaning: Option<Meaning>,
    /// Board that sent it.
    pub from: Node,
    /// Boards whose controllers received it: powered, on the same side of a cut.
    pub reached: Nodes,
}

impl Seen {
    /// A frame whose meaning is looked up in `scope`.
    pub fn new(bus: Bus, frame: WireFrame, scope: Scope, from: Node, reached: Nodes) -> Seen {
        Seen { bus, meaning: Meaning::decode(&frame, scope), frame, from, reached }
    }

    /// Returns the board of a Node-ID in its COB-ID: of two masters the one that sent it.
    pub fn board(&self, node: Node) -> Node {
        if node == MASTER && is_master(self.from) { self.from } else { node }
    }
}

/// The frames among records, in the same order.
pub fn frames(records: &[Occurrence]) -> impl Iterator<Item = (Time, &Seen)> {
    records.iter().filter_map(|record| match &record.what {
        FlightEvent::Frame(seen) => Some((record.at, seen)),
        _ => None,
    })
}

/// Returns an instant in virtual seconds, rounded to microseconds.
pub fn seconds(at: Time) -> f64 {
    (at.as_secs_f64() * 1e6).round() / 1e6
}

/// A cut of a bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlan {
    /// Bus that is cut.
    pub bus: Bus,
    /// Time of the cut.
    pub at: Time,
    /// Metres from the master's end.
    pub position_m: f64,
}

/// An event of a flight.
#[derive(Clone, Debug, PartialEq)]
pub enum FlightEvent {
    /// A board got power.
    PowerOn(Node),
    /// A board lost its power.
    PowerOff(Node),
    /// A fault pulled the reset pin of a board.
    Reset(Node),
    /// A fault cut a bus.
    Cut(CutPlan),
    /// Another fault of a bus, or the end of one.
    Other {
        /// The bus.
        bus: Bus,
        /// Name in pictures, one word.
        name: &'static str,
        /// The fault in a sentence, without its time.
        text: String,
    },
    /// A frame completed.
    Frame(Seen),
    /// A firmware logged a line.
    Log {
        /// Board of the firmware.
        node: Node,
        /// Severity.
        level: Level,
        /// The text, one line.
        text: String,
    },
}

/// An event and its instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Occurrence {
    /// Virtual time; for a frame the end of its last bit.
    pub at: Time,
    /// The event.
    pub what: FlightEvent,
}
