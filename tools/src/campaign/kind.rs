//! Kinds of faults.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Kind of a fault, by its name in scripts and tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Both wires of a bus break at a place (ECSS Table 5-2, case 8).
    Cut,
    /// A bus is recessive on a piece of cable (cases 3b to 7).
    Short,
    /// A bus is dominant on a piece of cable.
    Dominant,
    /// A node loses the connection by its stub, or its ground.
    Disconnect,
    /// Bit errors at each node: a reduced margin (cases 1, 2, 3a, 4, 9).
    Noise,
    /// The driver of a node is stuck dominant.
    Stuck,
    /// A node sends one frame continuously.
    Babble,
    /// The oscillator behind a controller is wrong.
    Drift,
    /// The level that nodes see is disturbed for a time.
    Glitch,
    /// One bit of a frame is inverted.
    Flip,
    /// A foreign node sends NMT commands.
    ForeignNmt,
    /// A foreign node sends heartbeats of the master.
    ForeignMaster,
    /// A foreign node sends heartbeats of a node that does not exist.
    UnknownNode,
    /// A foreign node sends heartbeats of a slave.
    Clash,
    /// A foreign node sends frames back to back.
    ForeignLoad,
    /// The master is reset.
    ResetMaster,
    /// A slave is reset.
    ResetSlave,
    /// The master loses its power.
    PowerMaster,
    /// A slave loses its power.
    PowerSlave,
}

impl Kind {
    /// Returns the kinds that affect one node, its stub or the cable beside it: two of them may have one cause.
    pub fn local() -> Vec<Kind> {
        let is_local = |kind: &Kind| !kind.is_foreign() && *kind != Kind::Noise;
        Kind::value_variants().iter().copied().filter(is_local).collect()
    }

    /// Returns its name.
    pub fn name(self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
    }

    /// Returns whether it continues until it is ended.
    pub fn lasts(self) -> bool {
        matches!(
            self,
            Kind::Cut | Kind::Short | Kind::Dominant | Kind::Disconnect | Kind::Noise | Kind::Stuck
        ) || matches!(self, Kind::Babble | Kind::Drift | Kind::Glitch | Kind::PowerMaster | Kind::PowerSlave)
    }

    /// Returns whether it may last to the end of a run: the rest of the network must still work.
    pub fn may_stay(self) -> bool {
        self.lasts() && !self.is_slow() && !matches!(self, Kind::Glitch | Kind::PowerMaster)
    }

    /// Returns whether the wire has to compute every bit of every node while it lasts, so that it may last only for a
    /// short time.
    pub fn is_slow(self) -> bool {
        matches!(self, Kind::Dominant | Kind::Stuck | Kind::Babble | Kind::Drift)
    }

    /// Returns whether it consists of frames of a foreign node.
    pub fn is_foreign(self) -> bool {
        matches!(
            self,
            Kind::ForeignNmt | Kind::ForeignMaster | Kind::UnknownNode | Kind::Clash | Kind::ForeignLoad
        )
    }

    /// Returns whether it affects the cable at a position.
    pub fn has_place(self) -> bool {
        matches!(self, Kind::Cut | Kind::Short | Kind::Dominant)
    }

    /// Returns whether it belongs to a node and not to a bus.
    pub fn is_of_node(self) -> bool {
        matches!(self, Kind::ResetMaster | Kind::ResetSlave | Kind::PowerMaster | Kind::PowerSlave)
    }
}
