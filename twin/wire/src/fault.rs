//! Faults of cable, nodes and line, at a given time; what cannot be is refused with the reason.

use crate::controller::NodeIndex;
use crate::encode::LONGEST;
use crate::field::Field;
use crate::frame::WireFrame;
use crate::time::Time;

/// What a disturbance does to the level that a node sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// The other level.
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

    /// These.
    ///
    /// # Panics
    /// When an index exceeds 127: no wire has so many nodes.
    pub fn of(nodes: &[NodeIndex]) -> Self {
        Nodes(nodes.iter().fold(0, |mask, &node| {
            assert!(node < 128, "a wire has at most 128 nodes, there is no node {node}");
            mask | 1 << node
        }))
    }

    /// Names nodes of a wire of `count` nodes.
    fn check(self, count: usize) -> Result<(), FaultError> {
        let beyond = 128 - self.0.leading_zeros() as usize;
        match self {
            Nodes(0) => Err(FaultError::NoNode),
            Nodes::ALL => Ok(()),
            _ if beyond > count => Err(FaultError::Node { node: beyond - 1, count }),
            _ => Ok(()),
        }
    }

    /// Is one of them.
    pub fn contains(self, node: NodeIndex) -> bool {
        self.0 >> node & 1 == 1
    }
}

/// Something that happens to a wire. Positions are metres from its left end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Both wires break here; a node at exactly this position belongs to the right piece. A second cut at the same
    /// position changes nothing.
    Cut {
        /// Where.
        position_m: f64,
    },
    /// The break at exactly this position heals; without one nothing changes.
    Restore {
        /// Where.
        position_m: f64,
    },
    /// Every break heals.
    RestoreAll,
    /// The piece of cable here shows one level, whatever is sent (`true`: recessive).
    Short {
        /// Where.
        position_m: f64,
        /// Its level.
        level: bool,
    },
    /// Every short is gone.
    ClearShorts,
    /// The stub of a node opens: it sees nothing but itself, and nobody sees it.
    Disconnect(NodeIndex),
    /// The stub is whole again.
    Reconnect(NodeIndex),
    /// A node loses its power: it drives nothing and takes no part, until [`Fault::PowerOn`].
    PowerOff(NodeIndex),
    /// It comes back, with error counters of zero.
    PowerOn(NodeIndex),
    /// The driver of a node is stuck dominant.
    StuckDominant(NodeIndex),
    /// It is free again.
    ReleaseDriver(NodeIndex),
    /// A node sends this frame whenever the bus is free, instead of what its controller wants to send.
    Babble(NodeIndex, WireFrame),
    /// It stops with the frame under way.
    StopBabbling(NodeIndex),
    /// The oscillator of a node runs this many parts per billion fast, beyond what its controller says, from its next
    /// frame on: +1 000 000 000 is twice the bit rate.
    Drift(NodeIndex, i32),
    /// A disturbance of the line, as these nodes see it.
    Glitch {
        /// Who sees it.
        nodes: Nodes,
        /// How long.
        duration: Time,
        /// What.
        effect: Effect,
    },
    /// The next bit at a place in the traffic reads as its opposite.
    Flip(Flip),
    /// From here on each node sees each microsecond inverted with this probability (1 Mbit/s: the bit error rate);
    /// zero ends it.
    BitErrors {
        /// Probability, 0 to 1.
        rate: f64,
        /// Of the random numbers.
        seed: u64,
    },
}

/// A bit that reads as its opposite, once for each of some nodes.
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
    /// Strikes each of `nodes` at the next bit that it sees at `place`.
    pub fn new(place: Place, nodes: Nodes) -> Self {
        Flip { place, left: nodes }
    }

    pub(crate) fn strikes(&self, node: NodeIndex, field: Field, position: Option<usize>) -> bool {
        self.left.contains(node)
            && match self.place {
                Place::Bit(bit) => position == Some(bit),
                Place::Field(place) => place == field,
            }
    }

    /// `node` has been struck; `true` when nobody is left.
    pub(crate) fn strike(&mut self, node: NodeIndex) -> bool {
        self.left = Nodes(self.left.0 & !(1 << node));
        self.is_spent()
    }

    pub(crate) fn is_spent(&self) -> bool {
        self.left.0 == 0
    }

    /// Only nodes that there are.
    pub(crate) fn among(self, count: usize) -> Flip {
        let all = u128::MAX.checked_shr(128 - count as u32).unwrap_or(0);
        Flip { left: Nodes(self.left.0 & all), ..self }
    }
}

/// Why a fault cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FaultError {
    /// A position that no cable has.
    #[error("a position on a cable is a finite number of metres from 0 on, not {0}")]
    Position(f64),
    /// There is no such node.
    #[error("there is no node {node}: the wire has {count}, counted from 0")]
    Node {
        /// Asked for.
        node: NodeIndex,
        /// Nodes of the wire.
        count: usize,
    },
    /// A disturbance that no node would see.
    #[error("a disturbance names at least one node")]
    NoNode,
    /// A probability outside 0 to 1.
    #[error("a bit error rate lies between 0 and 1, not at {0}")]
    Rate(f64),
    /// A disturbance without length.
    #[error("a disturbance lasts at least one tick of 1/336 us")]
    NoDuration,
    /// An oscillator that stands still or runs backwards.
    #[error("an oscillator cannot be {0} ppb off: more than -1 000 000 000 is possible")]
    Drift(i32),
    /// A place that no bit has.
    #[error("no bit is at {0:?}")]
    Place(Place),
    /// A time that has passed.
    #[error("{at:?} has passed: it is {now:?}")]
    Past {
        /// Asked for.
        at: Time,
        /// The present of the wire.
        now: Time,
    },
}

impl Fault {
    /// Can happen to a wire of `count` nodes.
    pub(crate) fn check(&self, count: usize) -> Result<(), FaultError> {
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
