//! Waveforms, as an oscilloscope with a protocol decoder on every node would show them.
//!
//! [`Wire::record_waveform`](crate::wire::bus::Wire::record_waveform) records one for a span of time, in which every bit is
//! computed. Otherwise it costs no time.

mod recorder;

use crate::wire::controller::{ErrorCounters, NodeIndex, WireEvent};
use crate::wire::field::Field;
use crate::wire::time::Time;

/// Every bit of every node of a wire, for a span of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Waveform {
    /// Begin of the span.
    pub from: Time,
    /// End of the span. Bits that are incomplete there are missing.
    pub to: Time,
    /// Nodes by index of attachment.
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
    /// Bits in chronological order; none while the node is idle.
    pub bits: Vec<Bit>,
    /// Level changes of its driver (`true`: recessive), beginning with the level at the begin of the span.
    pub driver: Vec<(Time, bool)>,
    /// Level changes at its receiver, beginning with the level at the begin of the span.
    pub line: Vec<(Time, bool)>,
    /// Events reported by the wire, in chronological order.
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
    /// Field to which it belongs.
    pub field: Field,
    /// Sampled level (`true`: recessive).
    pub sampled: bool,
    /// Level that the node sent.
    pub driven: bool,
    /// A fault inverted it ([`Fault::Flip`](crate::wire::fault::Fault::Flip)).
    pub flipped: bool,
    /// Ticks by which a resynchronisation made it longer, or shorter if negative.
    pub resynchronised: i64,
}
