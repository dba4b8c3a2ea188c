//! A CAN_RX line and a node that captures its falling edges and receives frames.
//!
//! Bits come from the wire's encoder. Time is in ticks of the node's timer, so that only the transmitter's clock errs.

use can_twin::wire::encode::encode;
use can_twin::wire::frame::WireFrame;
use ecss_can::link::{Captured, EDGES, EdgeRing, Miss, Stamp, StampSource};
use ecss_can::types::{CobId, Frame, Instant};

/// Ticks of the node's timer in a microsecond.
pub const PER_MICRO: u32 = 84;
/// Length of a bit at 1 Mbit/s, and of a microsecond.
pub const BIT: f64 = 84.0;
/// ACK delimiter and EOF.
const AFTER_ACK_SLOT: usize = 8;

/// Timing of a transmission.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sent {
    /// Clock error of the transmitter, parts per million. Positive values are longer bits.
    pub ppm: f64,
    /// Time by which a contender drives the edges of the identifier earlier than the winner, bits.
    pub early: f64,
    /// Delay of the receivers' ACK slot relative to the transmitter, bits.
    pub ack_late: f64,
}

/// A frame that all nodes received.
#[derive(Clone, Copy, Debug)]
pub struct Complete {
    pub frame: WireFrame,
    pub end: f64,
}

/// Edges of a line, in the order of time.
#[derive(Debug)]
pub struct Line {
    pub now: f64,
    pub falls: Vec<f64>,
}

/// Returns the bits at which a falling edge begins.
pub fn falls(frame: &WireFrame) -> Vec<usize> {
    let encoded = encode(frame);
    let bits = encoded.bits();
    (0..bits.len()).filter(|&n| !bits[n] && (n == 0 || bits[n - 1])).collect()
}

/// Returns the bit at which the edge begins that a stamp uses: the first one that only the winner drives. The last two
/// bits of the arbitration field, RTR and IDE, are dominant, and no contender is left after them.
pub fn reference(frame: &WireFrame) -> usize {
    let contended = encode(frame).arbitration_len() - 2;
    falls(frame).into_iter().find(|n| *n >= contended).expect("no more than five bits in a row are equal")
}

impl Line {
    pub fn new(now: f64) -> Self {
        Line { now, falls: Vec::new() }
    }

    pub fn idle(&mut self, bits: f64) {
        self.now += bits * BIT;
    }

    /// Adds a frame from SOF to the last bit of EOF.
    pub fn frame(&mut self, frame: &WireFrame, sent: Sent) -> Complete {
        let encoded = encode(frame);
        let bit = BIT * (1.0 + sent.ppm / 1e6);
        let (start, ack) = (self.now, encoded.bits().len() - AFTER_ACK_SLOT - 1);
        let reference = reference(frame);
        for n in falls(frame) {
            let shift = match n {
                n if n == ack => sent.ack_late,
                n if n < reference => -sent.early,
                _ => 0.0,
            };
            self.falls.push(start + n as f64 * bit + shift * BIT);
        }
        self.now = start + encoded.bits().len() as f64 * bit;
        Complete { frame: *frame, end: self.now }
    }

    /// Adds the first `bits` bits of a frame, then an error flag of `flag` bits with its echo, and the delimiter.
    pub fn destroyed(&mut self, frame: &WireFrame, bits: usize, flag: usize) {
        let encoded = encode(frame);
        let start = self.now;
        let before = falls(frame).into_iter().filter(|n| *n < bits);
        self.falls.extend(before.map(|n| start + n as f64 * BIT));
        if bits == 0 || encoded.bits()[bits - 1] {
            self.falls.push(start + bits as f64 * BIT);
        }
        self.now = start + (bits + flag + 8) as f64 * BIT;
    }
}

/// A node with an edge ring.
pub struct Node {
    ring: EdgeRing<PER_MICRO>,
    next: usize,
    fed: usize,
}

impl Node {
    /// Makes a node whose first edge goes to the cell `next`.
    pub fn new(next: usize) -> Self {
        Node { ring: EdgeRing::new(), next: next % EDGES, fed: 0 }
    }

    fn capture(&mut self, at: f64) {
        self.ring.cells()[self.next].store(at as u64 as u32, std::sync::atomic::Ordering::Relaxed);
        self.next = (self.next + 1) % EDGES;
    }

    /// Captures the falling edges until `until`.
    pub fn follow(&mut self, line: &Line, until: f64) {
        while let Some(&at) = line.falls.get(self.fed).filter(|at| **at <= until) {
            self.capture(at);
            self.fed += 1;
        }
    }

    /// Returns the stamp that the node gets at `task` for a frame that its interrupt found at `interrupt`. No later
    /// equal frame has been received.
    pub fn stamp(&self, frame: &WireFrame, interrupt: f64, task: f64) -> Result<Stamp, Miss> {
        let reported = Stamp::interrupt(Instant::from_micros(interrupt as u64 / BIT as u64));
        let line = Captured { next: self.next, alone_until: task.max(interrupt + BIT) as u64 as u32 };
        let frame = Frame::new(CobId::new(id(frame)).unwrap(), frame.payload()).unwrap();
        self.ring.stamp(line, &frame, reported, BIT as u32)
    }
}

fn id(frame: &WireFrame) -> u16 {
    match frame.id {
        can_twin::wire::frame::WireId::Standard(id) => id,
        can_twin::wire::frame::WireId::Extended(_) => panic!("the product has no frames with 29 bits"),
    }
}

/// Returns the difference between a captured stamp and the end of its frame, ticks.
pub fn error(stamp: &Stamp, complete: &Complete) -> f64 {
    assert_eq!(stamp.source, StampSource::Capture);
    assert_eq!(stamp.at, stamp.fine().instant());
    let ticks = stamp.fine().ticks(PER_MICRO);
    assert_eq!(stamp.low::<PER_MICRO>(), ticks as u32);
    ticks as f64 - complete.end
}
