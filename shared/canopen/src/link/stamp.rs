//! Stamps of frames: the instant at which a frame ended, on the clock of the node.
//!
//! A timer captures every falling edge of CAN_RX into an [`EdgeRing`], without the CPU. When a frame is reported,
//! the ring is searched for exactly the edges that this frame makes on the wire. The end of the frame follows from
//! one of them.

use core::sync::atomic::{AtomicU32, Ordering};
use thiserror::Error;

use super::pattern::Pattern;
use crate::types::{FineInstant, Frame, Instant};

/// Instant at which a frame ended: the last bit of its EOF, as the CAN_RX of the node shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Stamp {
    /// End of the frame, rounded down to a microsecond, for protocol timers.
    pub at: Instant,
    /// Units of 2^-8 µs beyond that; zero without a capture timer.
    fraction: u8,
    /// Way in which the end was measured.
    pub source: StampSource,
}

/// Way in which a [`Stamp`] was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StampSource {
    /// Read in the interrupt at the end of the frame. Late by the interrupt latency: some microseconds, without a
    /// bound. Early by at most one bit, because a receiver accepts a frame one bit before its end.
    Interrupt,
    /// Computed from a captured edge and the known rest of the frame. The error is at most [`EdgeRing::ERROR`]
    /// plus the constant delay of the timer's input. A disturbance that moves this edge moves the stamp by the
    /// same time, at most by a quarter of a bit: beyond that the other edges do not match.
    Capture,
}

impl Stamp {
    /// Makes a stamp that was read in the interrupt of the frame.
    pub const fn interrupt(at: Instant) -> Stamp {
        Stamp { at, fraction: 0, source: StampSource::Interrupt }
    }

    /// Makes a stamp that a timer measured by captured edges, for a port that finds the edges of a frame in its
    /// own way.
    pub const fn captured(end: FineInstant) -> Stamp {
        Stamp { at: end.instant(), fraction: end.units() as u8, source: StampSource::Capture }
    }

    /// Returns the stamp of the low word `low`: the instant nearest to that of the interrupt. It divides 32 bits,
    /// not 64.
    fn capture<const PER_MICRO: u32>(reported: Stamp, low: u32) -> Stamp {
        let apart = later(low, low_word(reported.at, PER_MICRO));
        let per_micro = PER_MICRO as i32;
        let at = reported.at.as_micros().saturating_add_signed(i64::from(apart.div_euclid(per_micro)));
        let fraction = fraction_of(apart.rem_euclid(per_micro) as u32, PER_MICRO);
        Stamp { at: Instant::from_micros(at), fraction, source: StampSource::Capture }
    }

    /// Returns the end of the frame with its full resolution.
    pub fn fine(&self) -> FineInstant {
        let whole: FineInstant = self.at.into();
        FineInstant::from_units(whole.units().saturating_add(u64::from(self.fraction)))
    }

    /// Returns the low word of a timer that counts `PER_MICRO` in a microsecond and runs since power-on.
    pub const fn low<const PER_MICRO: u32>(&self) -> u32 {
        const UNITS: u32 = FineInstant::PER_MICRO as u32;
        low_word(self.at, PER_MICRO).wrapping_add((self.fraction as u32 * PER_MICRO + UNITS / 2) / UNITS)
    }
}

/// The low word of a timer at the beginning of a microsecond.
const fn low_word(at: Instant, per_micro: u32) -> u32 {
    (at.as_micros() as u32).wrapping_mul(per_micro)
}

/// Units of 2^-8 µs in less than a microsecond of a timer, to the nearest.
const fn fraction_of(ticks: u32, per_micro: u32) -> u8 {
    ((ticks * FineInstant::PER_MICRO as u32 + per_micro / 2) / per_micro) as u8
}

/// Reason why the edges of a frame gave no stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Miss {
    /// There is no edge from the time of the frame: a wire is missing, or later edges replaced it.
    #[error("there is no edge from the time of the frame: look at the capture wire")]
    Silent,
    /// Edges were found, but one is missing, one is too many, or one is in a wrong place.
    #[error("the edges do not fit the frame")]
    Mismatch,
    /// The interrupt came a frame late. An earlier frame may have these edges.
    #[error("the interrupt came a frame late")]
    Late,
    /// The edges were found more than once, or another frame like this one was reported meanwhile.
    #[error("more than one frame fits the edges")]
    Ambiguous,
}

/// State of the capture of a line when a stamp is requested.
#[derive(Clone, Copy, Debug)]
pub struct Captured {
    /// Cell of the next edge, `0..EDGES`.
    pub next: usize,
    /// Instant until which no later frame like this one was received or sent: low word of the timer, at least a
    /// bit after the report.
    pub alone_until: u32,
}

/// Number of frame lengths that the search goes back. A report that is later than the depth of a receive FIFO
/// (three frames) finds no edges.
const SEARCHED: u32 = 4;

/// Number of edges in a ring. They cover at least 512 bits of any traffic.
pub const EDGES: usize = 256;

/// Falling edges of one CAN_RX line, which a DMA writes into a ring. Each is the low word of a timer that counts
/// `PER_MICRO`, 1 to 256, in a microsecond and runs since power-on.
///
/// The ring has no count of laps: an edge that replaced another one does not match the pattern of its neighbours.
pub struct EdgeRing<const PER_MICRO: u32> {
    cells: [AtomicU32; EDGES],
}

/// Bits of the longest frame from the edge that its stamp is taken from to its end.
const LONGEST: u32 = 119;
/// Most that two clocks are apart, parts per million.
const APART: u32 = 200;

impl<const PER_MICRO: u32> EdgeRing<PER_MICRO> {
    /// Greatest error of a captured stamp at 1 Mbit/s, in ticks: one for the phase of the edge against the timer,
    /// one for rounding, the others for 200 ppm between the clocks over the longest frame. 48 ns at 84 MHz.
    pub const ERROR: u32 = 2 + (PER_MICRO * LONGEST * APART).div_ceil(1_000_000);

    /// Makes a ring without edges.
    pub const fn new() -> Self {
        const { assert!(1 <= PER_MICRO && PER_MICRO <= 256, "a capture timer of 1 to 256 MHz") };
        EdgeRing { cells: [const { AtomicU32::new(0) }; EDGES] }
    }

    /// Returns the cells that the DMA writes to.
    pub const fn cells(&self) -> &[AtomicU32; EDGES] {
        &self.cells
    }

    /// Returns the stamp of a frame that was reported with the stamp `reported`. `bit` is the length of a bit in ticks.
    ///
    /// Each call removes from the ring the edges that it uses. So they are not found again, not even when the low
    /// word has returned to the same value.
    ///
    /// # Errors
    /// [`Miss`] if the end of the frame is not certain.
    pub fn stamp(&self, line: Captured, frame: &Frame, reported: Stamp, bit: u32) -> Result<Stamp, Miss> {
        let pattern = Pattern::of(frame);
        let search = Search { cells: &self.cells, next: line.next, bit, pattern: &pattern };
        // A receiver has a frame one bit before its end, by a bit grid 0.3 early to 0.7 bit late; the clock of the
        // interrupt is rounded to a microsecond and up to another one off the timer.
        let reported_by = reported.low::<PER_MICRO>().wrapping_add(2 * bit + 2 * PER_MICRO);
        // The same bit and its grid for the next frame like it, which was not there until then.
        let alone_until = line.alone_until.wrapping_add(search.percent(30) as u32);
        let latest = if later(reported_by, alone_until) < 0 { reported_by } else { alone_until };
        let before = |at: u32| latest.wrapping_sub(at);

        let length = u32::from(pattern.length) * bit;
        let (mut found, mut more, mut heard) = (None, false, false);
        for back in 0..EDGES.saturating_sub(pattern.edges.len()) {
            let age = later(latest, search.edge(back));
            if age >= (SEARCHED * length) as i32 {
                break;
            }
            heard |= age >= 0 && age < 2 * length as i32;
            if let Some(end) = search.end_of_match(back)
                && later(latest, end) >= 0
            {
                search.take(back);
                more |= found.replace(end).is_some();
            }
        }
        match found {
            Some(_) if more => Err(Miss::Ambiguous),
            // Two equal frames end at least their length apart: no earlier one ended here.
            Some(end) if before(end) < length => Ok(Stamp::capture::<PER_MICRO>(reported, end)),
            Some(_) => Err(Miss::Late),
            None if heard => Err(Miss::Mismatch),
            None => Err(Miss::Silent),
        }
    }
}

impl<const PER_MICRO: u32> Default for EdgeRing<PER_MICRO> {
    fn default() -> Self {
        Self::new()
    }
}

// Hundredths of a bit.

/// Tolerance of the edges that the transmitter alone drives.
const OFF: u32 = 25;
/// Tolerance to one side of edges that others may drive.
const EARLY_OR_LATE: u32 = 70;
/// After the start of the ACK slot: an edge in the last bit of EOF, 8 bits later, comes too late to spoil a reception.
/// Before that, form errors and the error flags of others make one.
const QUIET_AFTER_ACK: u32 = 775;
/// Within a frame there are at most 10 bits between falling edges. Before SOF there are 12, from the ACK slot of
/// another frame; tolerances make it 10.6.
const QUIET_BEFORE_SOF: u32 = 1_030;

/// The search for one pattern, from the newest edge back.
struct Search<'a> {
    cells: &'a [AtomicU32; EDGES],
    next: usize,
    bit: u32,
    pattern: &'a Pattern,
}

impl Search<'_> {
    /// The cell `back` places before the newest edge.
    fn cell(&self, back: usize) -> &AtomicU32 {
        let [first, ..] = self.cells;
        self.cells.get((self.next + 2 * EDGES - 1 - back) % EDGES).unwrap_or(first)
    }

    fn edge(&self, back: usize) -> u32 {
        self.cell(back).load(Ordering::Relaxed)
    }

    /// Hundredths of a bit in ticks.
    fn percent(&self, percent: u32) -> i32 {
        (self.bit * percent / 100) as i32
    }

    /// When the frame ended, if the edge `back` places before the newest is its ACK slot.
    ///
    /// Places are taken from the reference edge, which only the transmitter drives. Falling edges that are not this
    /// frame's are whole bits away, so tolerances to both sides must add up to less than one bit:
    /// * a quarter either way for edges of the transmitter: its clock and ours, jitter of the transceivers;
    /// * 0.7 bit early up to the end of the identifier: a contender nearer to us may drive them, by the propagation there
    ///   and back, which for 40 m is 0.7 µs;
    /// * 0.7 bit late for the ACK slot: receivers drive it, after the same propagation.
    fn end_of_match(&self, back: usize) -> Option<u32> {
        let ack = self.edge(back);
        let newer = back.checked_sub(1).map(|newer| self.edge(newer));
        // Most edges have another close behind and need no closer look.
        if newer.is_some_and(|newer| later(newer, ack) < self.percent(QUIET_AFTER_ACK - EARLY_OR_LATE)) {
            return None;
        }
        let Pattern { edges, reference, length } = self.pattern;
        let last = edges.len().checked_sub(1)?;
        let start = self
            .edge(back + last.checked_sub(*reference)?)
            .wrapping_sub(u32::from(*edges.get(*reference)?) * self.bit);
        let time = |position: u8| start.wrapping_add(u32::from(position) * self.bit);

        for (n, position) in edges.iter().enumerate().rev() {
            let late = later(self.edge(back + last - n), time(*position));
            let early = if n < *reference { EARLY_OR_LATE } else { OFF };
            let tardy = if n == last { EARLY_OR_LATE } else { OFF };
            if late < -self.percent(early) || late > self.percent(tardy) {
                return None;
            }
        }
        let quiet_until = time(self.pattern.ack()).wrapping_add(self.percent(QUIET_AFTER_ACK) as u32);
        let disturbed = newer.is_some_and(|newer| later(newer, quiet_until) < 0);
        let idle = self.edge(back + last).wrapping_sub(self.edge(back + last + 1));
        (!disturbed && idle >= self.percent(QUIET_BEFORE_SOF) as u32).then(|| time(*length))
    }

    /// Makes a match one no more: two edges at one time are in no pattern.
    fn take(&self, back: usize) {
        self.cell(back).store(self.edge(back + 1), Ordering::Relaxed);
    }
}

/// Returns the time from `than` to `edge`, within half a round of the timer.
fn later(edge: u32, than: u32) -> i32 {
    edge.wrapping_sub(than) as i32
}
