//! Faults of cable, nodes and line, at a given time. Impossible faults are refused with the reason.

use crate::wire::controller::NodeIndex;
use crate::wire::encode::LONGEST;
use crate::wire::field::Field;
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;

/// Effect of a disturbance on the level that a node sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// Inverted.
    Invert,
    /// Dominant, whatever is sent.
    Dominant,
    /// Recessive, whatever is sent.
    Recessive,
}

/// Some nodes of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Nodes(u128);

impl Nodes {
    /// Every node.
    pub const ALL: Nodes = Nodes(u128::MAX);

    /// Makes a set of these nodes.
    ///
    /// # Panics
    /// When an index exceeds 127, the largest number of nodes of a wire.
    pub fn of(nodes: &[NodeIndex]) -> Self {
        Nodes(nodes.iter().fold(0, |mask, &node| {
            assert!(node < 128, "a wire has at most 128 nodes, there is no node {node}");
            mask | 1 << node
        }))
    }

    /// Checks that all nodes are on a wire of `count` nodes.
    fn check(self, count: usize) -> Result<(), FaultError> {
        let beyond = 128 - self.0.leading_zeros() as usize;
        match self {
            Nodes(0) => Err(FaultError::NoNode),
            Nodes::ALL => Ok(()),
            _ if beyond > count => Err(FaultError::Node { node: beyond - 1, count }),
            _ => Ok(()),
        }
    }

    /// Returns whether a node is in the set.
    pub fn contains(self, node: NodeIndex) -> bool {
        self.0 >> node & 1 == 1
    }
}

/// Fault of a wire, or its end. Positions are metres from its left end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Both wires break here; a node at exactly this position belongs to the right piece. A second cut at the same
    /// position changes nothing.
    Cut {
        /// Position of the break, in metres.
        position_m: f64,
    },
    /// The break at exactly this position heals; without one nothing changes.
    Restore {
        /// Position of the break, in metres.
        position_m: f64,
    },
    /// Every break heals.
    RestoreAll,
    /// The piece of cable at a position is stuck at one level.
    Short {
        /// Position on the piece, in metres.
        position_m: f64,
        /// Level of the piece (`true`: recessive).
        level: bool,
    },
    /// All shorts end.
    ClearShorts,
    /// The stub of a node opens: it is connected to no other node.
    Disconnect(NodeIndex),
    /// The stub is whole again.
    Reconnect(NodeIndex),
    /// A node loses its power: it drives nothing and takes no part, until [`Fault::PowerOn`].
    PowerOff(NodeIndex),
    /// A node gets its power back, with error counters of zero.
    PowerOn(NodeIndex),
    /// The driver of a node is stuck dominant.
    StuckDominant(NodeIndex),
    /// The driver of a node is no longer stuck.
    ReleaseDriver(NodeIndex),
    /// A node sends this frame whenever the bus is free, instead of what its controller wants to send.
    Babble(NodeIndex, WireFrame),
    /// The babbling node stops after the present frame.
    StopBabbling(NodeIndex),
    /// The oscillator of a node runs fast by this many parts per billion in addition to its controller's timing, from
    /// its next frame on: +1 000 000 000 is twice the bit rate.
    Drift(NodeIndex, i32),
    /// A disturbance of the line at some nodes.
    Glitch {
        /// Nodes that see it.
        nodes: Nodes,
        /// Duration.
        duration: Time,
        /// Effect on the level.
        effect: Effect,
    },
    /// The next bit at a place in the traffic is inverted.
    Flip(Flip),
    /// From now on each node sees each microsecond inverted with a probability, which is the bit error rate at 1
    /// Mbit/s. Zero ends it.
    BitErrors {
        /// Probability, 0 to 1.
        rate: f64,
        /// Seed of the random numbers.
        seed: u64,
    },
}

/// An inverted bit, once for each of some nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    place: Place,
    left: Nodes,
}

/// A place in the traffic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// Bit of a frame, stuff bits included; 0 is SOF.
    Bit(usize),
    /// A field.
    Field(Field),
}

impl Flip {
    /// Makes a flip that inverts, for each of `nodes`, the next bit that it sees at `place`.
    pub fn new(place: Place, nodes: Nodes) -> Self {
        Flip { place, left: nodes }
    }

    pub(in crate::wire) fn strikes(&self, node: NodeIndex, field: Field, position: Option<usize>) -> bool {
        self.left.contains(node)
            && match self.place {
                Place::Bit(bit) => position == Some(bit),
                Place::Field(place) => place == field,
            }
    }

    /// Removes `node` after its flip. Returns `true` if no node is left.
    pub(in crate::wire) fn strike(&mut self, node: NodeIndex) -> bool {
        self.left = Nodes(self.left.0 & !(1 << node));
        self.is_spent()
    }

    pub(in crate::wire) fn is_spent(&self) -> bool {
        self.left.0 == 0
    }

    /// Limits the flip to the nodes of a wire with `count` nodes.
    pub(in crate::wire) fn among(self, count: usize) -> Flip {
        let all = u128::MAX.checked_shr(128 - count as u32).unwrap_or(0);
        Flip { left: Nodes(self.left.0 & all), ..self }
    }
}

/// Reason why a fault is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FaultError {
    /// The position is invalid.
    #[error("a position on a cable is a finite number of metres from 0 on, not {0}")]
    Position(f64),
    /// There is no such node.
    #[error("there is no node {node}: the wire has {count}, counted from 0")]
    Node {
        /// Node in the fault.
        node: NodeIndex,
        /// Number of nodes of the wire.
        count: usize,
    },
    /// The disturbance has no nodes.
    #[error("a disturbance names at least one node")]
    NoNode,
    /// The probability is not in 0 to 1.
    #[error("a bit error rate lies between 0 and 1, not at {0}")]
    Rate(f64),
    /// The disturbance has no duration.
    #[error("a disturbance lasts at least one tick of 1/336 us")]
    NoDuration,
    /// The oscillator would stand still or run backwards.
    #[error("an oscillator cannot be {0} ppb off: more than -1 000 000 000 is possible")]
    Drift(i32),
    /// No bit has this place.
    #[error("no bit is at {0:?}")]
    Place(Place),
    /// The time has passed.
    #[error("{at:?} has passed: it is {now:?}")]
    Past {
        /// Requested time.
        at: Time,
        /// The present of the wire.
        now: Time,
    },
}

impl Fault {
    /// Checks that the fault is possible on a wire of `count` nodes.
    pub(in crate::wire) fn check(&self, count: usize) -> Result<(), FaultError> {
        let position = |at: f64| {
            let exists = at.is_finite() && at >= 0.0;
            if exists { Ok(()) } else { Err(FaultError::Position(at)) }
        };
        let node =
            |node: NodeIndex| if node < count { Ok(()) } else { Err(FaultError::Node { node, count }) };
        match *self {
            Fault::Cut { position_m } | Fault::Restore { position_m } | Fault::Short { position_m, .. } => {
                position(position_m)
            }
            Fault::Disconnect(n)
            | Fault::Reconnect(n)
            | Fault::PowerOff(n)
            | Fault::PowerOn(n)
            | Fault::StuckDominant(n)
            | Fault::ReleaseDriver(n)
            | Fault::Babble(n, _)
            | Fault::StopBabbling(n) => node(n),
            Fault::Drift(n, ppb) if ppb > -1_000_000_000 => node(n),
            Fault::Drift(_, ppb) => Err(FaultError::Drift(ppb)),
            Fault::Glitch { duration: Time(0), .. } => Err(FaultError::NoDuration),
            Fault::Glitch { nodes, .. } => nodes.check(count),
            Fault::Flip(flip) if !flip.place.exists() => Err(FaultError::Place(flip.place)),
            Fault::Flip(flip) => flip.left.check(count),
            Fault::BitErrors { rate, .. } if !(0.0..=1.0).contains(&rate) => Err(FaultError::Rate(rate)),
            Fault::BitErrors { .. } | Fault::RestoreAll | Fault::ClearShorts => Ok(()),
        }
    }
}

impl Place {
    fn exists(self) -> bool {
        match self {
            Place::Bit(bit) => bit < LONGEST,
            Place::Field(field) => match field {
                Field::Identifier(n) => n < 11,
                Field::Extension(n) => n < 18,
                Field::Reserved(n) => n < 2,
                Field::Dlc(n) => n < 4,
                Field::Data(n) => n < 64,
                Field::Crc(n) => n < 15,
                Field::Eof(n) => n < 7,
                Field::Intermission(n) => n < 3,
                Field::Suspend(n) => n < 8,
                Field::OverloadFlag(n) => n < 6,
                Field::Delimiter(n) => (1..8).contains(&n),
                Field::Idle => false,
                _ => true,
            },
        }
    }
}
