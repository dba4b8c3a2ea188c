//! What was recorded of a run.

use can_wire::time::Time;
use ecss_can::redundancy::Strap;
use ecss_can::types::{Bus, NodeId};
use twin::bxcan::Exchange;

/// Recorded run of a spacecraft.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Record of each board.
    pub boards: Vec<BoardRecord>,
}

/// Record of a board.
#[derive(Clone, Debug)]
pub struct BoardRecord {
    /// Name of the board in reports.
    pub name: String,
    /// Part of the board in the network.
    pub part: Part,
    /// Error of its crystal, parts per million.
    pub ppm: f64,
    /// Unique ID of its chip.
    pub uid: [u8; 12],
    /// All that was recorded of it, in the order of time.
    pub entries: Vec<Entry>,
}

/// Part of a board in the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Slave with this Node-ID and parallel access.
    Slave(NodeId),
    /// Master. `None`: it is the only one.
    Master(Option<Strap>),
}

/// Entry of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Instant on the time axis of the run.
    pub at: Time,
    /// What happened.
    pub what: What,
}

/// Something that was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// Program and controller of this bus handed over a frame, or the chip was reset.
    Exchange(Bus, Exchange),
    /// The program logged this line.
    Line(String),
}
