//! Reports of the observer: changes of nodes, recoveries and takeovers.

use can_twin::wire::time::Time;

use super::phase::Span;
use super::record::Node;

/// A change detected by the observer, for the narrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A node changed phase or bus.
    Now(Node, Span),
    /// The first proof that a slave works again, and the time since the fault. After a cut it works on the other bus;
    /// after the loss of the active master it works for the other one. In a flight of the shipped images the proof is a
    /// due command or telemetry, otherwise a heartbeat as operational.
    Recovered(Node, Since, Time),
    /// Another master board became active.
    TookOver(Takeover),
}

/// The fault from which a recovery is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// The cut of a bus.
    Cut,
    /// The loss of the active master.
    Loss,
}

impl Since {
    /// Returns the name of the fault in texts.
    pub fn name(self) -> &'static str {
        match self {
            Since::Cut => "the cut",
            Since::Loss => "the loss of the master",
        }
    }
}

/// Another board became the active master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Takeover {
    /// Board that was active.
    pub from: Node,
    /// Board that is active now.
    pub to: Node,
    /// End of the last heartbeat of the board that was active.
    pub last: Time,
    /// End of the first message of the board that is active now.
    pub first: Time,
}

impl Takeover {
    /// Returns the time without a message of a master.
    pub fn took(&self) -> Time {
        self.first.since(self.last)
    }
}
