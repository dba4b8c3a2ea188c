//! What an oscilloscope with a protocol decoder on every node would show.
//!
//! [`Wire::record_waveform`](crate::wire::Wire::record_waveform) switches it on for a span of time; meanwhile every
//! bit is computed. Off it costs nothing.

mod recorder;

use crate::controller::{ErrorCounters, NodeIndex, WireEvent};
use crate::field::Field;
use crate::time::Time;

/// Every bit of every node of a wire, for a span of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Waveform {
    /// Begin of the span.
    pub from: Time,
    /// Its end. What was under way there is missing.
    pub to: Time,
    /// By index of attachment.
    pub lanes: Vec<Lane>,
}

/// One node.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// The node.
    pub node: NodeIndex,
    /// Metres from the left end of the cable.
    pub position_m: f64,
    /// Nominal length of its bits at the begin of the span, by its own clock.
    pub bit_time: Time,
    /// Error counters at the begin of the span.
    pub counters: ErrorCounters,
    /// Bits in the order of time; none while the node is idle.
    pub bits: Vec<Bit>,
    /// From when on its driver sends which level (`true`: recessive); first the level at the begin of the span.
    pub driver: Vec<(Time, bool)>,
    /// From when on its receiver sees which level; first the level at the begin of the span.
    pub line: Vec<(Time, bool)>,
    /// What the wire told it, in the order of time.
    pub events: Vec<(Time, WireEvent)>,
}

/// One bit, as one node sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bit {
    /// Begin of SYNC_SEG.
    pub start: Time,
    /// Sample point.
    pub sample: Time,
    /// Begin of the next bit.
    pub end: Time,
    /// What it belongs to.
    pub field: Field,
    /// Level that the node took it for (`true`: recessive).
    pub sampled: bool,
    /// Level that the node sent.
    pub driven: bool,
    /// A fault made it read as its opposite ([`Fault::Flip`](crate::fault::Fault::Flip)).
    pub flipped: bool,
    /// Ticks by which a resynchronisation made it longer, or shorter if negative.
    pub resynchronised: i64,
}
