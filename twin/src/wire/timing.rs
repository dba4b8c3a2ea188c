//! Bit timing of one node: time quanta, sample point, synchronisation (ISO 11898-1, 11.3).

use crate::wire::fine::Fine;
use crate::wire::time::Time;

/// Length of a time quantum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Quantum(Fine);

impl Quantum {
    /// `ticks / per` ticks of [`Time`], rounded to 11 fs: a crystal's error of some ppm is a fraction of a tick.
    ///
    /// # Panics
    /// When either is zero: a clock has a period.
    pub fn new(ticks: u64, per: u64) -> Self {
        assert!(ticks > 0 && per > 0, "a time quantum has a length, not {ticks}/{per} ticks");
        Quantum(Fine::from_ratio(ticks, per))
    }

    /// Returns this quantum with an oscillator that runs `ppb` parts per billion fast.
    #[must_use]
    pub fn fast_by(self, ppb: i32) -> Self {
        let scale = i128::from(1_000_000_000 + i64::from(ppb));
        let exact = i128::from(self.0.0) * 1_000_000_000;
        Quantum(Fine(u64::try_from((exact + scale / 2) / scale).unwrap_or(u64::MAX)))
    }
}

/// The settings of a node: one bit is SYNC_SEG of one quantum, segment 1 up to the sample point, segment 2 after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BitTiming {
    quantum: Quantum,
    segment1: u8,
    segment2: u8,
    jump_width: u8,
}

impl BitTiming {
    /// 1 Mbit/s in 14 quanta of 1/14 us, sample point 86 %, SJW 1: bxCAN behind a clock of 42 MHz with prescaler 3.
    pub const MEGABIT: BitTiming =
        BitTiming { quantum: Quantum(Fine::from_time(Time(24))), segment1: 11, segment2: 2, jump_width: 1 };

    /// As [`BitTiming::MEGABIT`], at another bit rate.
    ///
    /// # Panics
    /// When it is zero.
    pub fn kbit(kbit_per_s: u32) -> Self {
        BitTiming { quantum: Quantum::new(24_000, kbit_per_s.into()), ..BitTiming::MEGABIT }
    }

    /// `segment1` holds PROP_SEG and PHASE_SEG1; all in quanta.
    ///
    /// # Panics
    /// When a segment or the jump width is zero, or the jump width exceeds segment 1: no chip can be set so.
    pub fn new(quantum: Quantum, segment1: u8, segment2: u8, jump_width: u8) -> Self {
        assert!(segment1 > 0 && segment2 > 0 && jump_width > 0, "segments and SJW have at least one quantum");
        assert!(jump_width <= segment1, "SJW {jump_width} exceeds segment 1 of {segment1} quanta");
        BitTiming { quantum, segment1, segment2, jump_width }
    }

    /// Returns the same settings with an oscillator that runs `ppb` parts per billion fast.
    #[must_use]
    pub fn fast_by(self, ppb: i32) -> Self {
        BitTiming { quantum: self.quantum.fast_by(ppb), ..self }
    }

    /// Quanta of one bit.
    pub fn quanta(&self) -> u64 {
        1 + u64::from(self.segment1) + u64::from(self.segment2)
    }

    /// Length of one bit, to the nearest tick.
    pub fn bit_time(&self) -> Time {
        self.bit().nearest()
    }

    /// Start of a bit to its sample point, to the nearest tick.
    pub fn sample_point(&self) -> Time {
        self.quantum.0.times(1 + u64::from(self.segment1)).nearest()
    }

    /// Bits per second, to the nearest one.
    pub fn bit_rate(&self) -> u32 {
        let (bits, bit) = (Fine::from_time(Time::from_ms(1_000)).0, self.bit().0);
        u32::try_from((bits + bit / 2) / bit).unwrap_or(u32::MAX)
    }

    pub(in crate::wire) fn bit(&self) -> Fine {
        self.quantum.0.times(self.quanta())
    }
}

/// A level change by a transmitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wire) struct Edge {
    /// Bits since the previous change.
    pub(in crate::wire) bits: u64,
    pub(in crate::wire) at: Fine,
    /// Level after the change.
    pub(in crate::wire) level: bool,
}

/// The bit clock of a node on its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wire) struct BitClock {
    pub(in crate::wire) timing: BitTiming,
    pub(in crate::wire) bit: Fine,
    pub(in crate::wire) start: Fine,
    pub(in crate::wire) sample: Fine,
    pub(in crate::wire) end: Fine,
    /// An edge was used since the last sample point ("only one synchronisation within one bit time").
    synchronised: bool,
    /// The level at the sample point, once that has passed with an edge after it.
    pub(in crate::wire) latched: Option<bool>,
    /// Level of the previous sample.
    previous: bool,
}

impl BitClock {
    pub(in crate::wire) fn new(timing: BitTiming, start: Fine) -> Self {
        let mut clock = BitClock {
            timing,
            bit: timing.bit(),
            start,
            sample: start,
            end: start,
            synchronised: false,
            latched: None,
            previous: true,
        };
        clock.place(start);
        clock
    }

    fn place(&mut self, start: Fine) {
        self.start = start;
        self.sample = start + self.timing.quantum.0.times(1 + u64::from(self.timing.segment1));
        self.end = start + self.bit;
    }

    /// Returns the sample of this bit, if `level` has not changed since the last edge.
    pub(in crate::wire) fn sampled(&self, level: bool) -> bool {
        self.latched.unwrap_or(level)
    }

    /// Begins the next bit; `sampled` is the level of the one that ends.
    pub(in crate::wire) fn next_bit(&mut self, sampled: bool) {
        if self.latched.take().is_none() {
            self.synchronised = false;
        }
        self.previous = sampled;
        self.place(self.end);
    }

    /// Advances by `bits` bits in which all samples are `level` and there is no edge.
    pub(in crate::wire) fn skip(&mut self, bits: u64, level: bool) {
        if bits > 0 {
            self.next_bit(level);
            if bits > 1 {
                self.synchronised = false;
                self.place(self.start + self.bit.times(bits - 1));
            }
        }
    }

    /// Keeps the sample if the line changes to `level` at `at` after the sample point.
    fn pass_sample_point(&mut self, at: Fine, level: bool) {
        if self.latched.is_none() && at > self.sample {
            self.latched = Some(!level);
            self.synchronised = false;
        }
    }

    /// Handles a rising edge, which does not synchronise.
    pub(in crate::wire) fn recessive_edge(&mut self, at: Fine) {
        self.pass_sample_point(at, true);
    }

    /// Handles a falling edge outside of idle: resynchronises (11.3.2.2). A node that sends dominant ignores a late
    /// edge, which may be its own.
    pub(in crate::wire) fn dominant_edge(&mut self, at: Fine, sends_dominant: bool) {
        self.pass_sample_point(at, false);
        let before = self.latched.unwrap_or(self.previous);
        if self.synchronised || !before {
            return;
        }
        let quantum = self.timing.quantum.0;
        let jump = u64::from(self.timing.jump_width);
        if self.latched.is_none() {
            let late = (at - self.start).0 / quantum.0;
            if late > 0 && sends_dominant {
                return;
            }
            let stretch = quantum.times(late.min(jump));
            self.sample = self.sample + stretch;
            self.end = self.end + stretch;
        } else {
            let begun = Fine((at - self.start).0 / quantum.0 * quantum.0);
            let early = (self.end - self.start).0 - begun.0;
            self.end = if early <= quantum.times(jump).0 {
                self.start + begun
            } else {
                self.end - quantum.times(jump)
            };
        }
        self.synchronised = true;
    }

    /// Handles a falling edge in idle at any time: a bit begins with the quantum that contains the edge (hard
    /// synchronisation, 11.3.2.1).
    pub(in crate::wire) fn begin_with_edge(&mut self, at: Fine) {
        let quantum = self.timing.quantum.0;
        let begun = Fine((at - self.start).0 / quantum.0 * quantum.0);
        self.latched = None;
        self.synchronised = true;
        self.previous = true;
        self.place(self.start + begun);
    }

    /// Handles a falling edge between frames: restarts the present bit before its sample point, and the next bit after
    /// it.
    pub(in crate::wire) fn hard_synchronise(&mut self, at: Fine) {
        self.pass_sample_point(at, false);
        if self.synchronised || !self.latched.unwrap_or(self.previous) {
            return;
        }
        if self.latched.is_none() {
            self.begin_with_edge(at);
        } else {
            let quantum = self.timing.quantum.0;
            self.end = self.start + Fine((at - self.start).0 / quantum.0 * quantum.0);
            self.synchronised = true;
        }
    }

    /// Starts a bit without an edge.
    pub(in crate::wire) fn restart(&mut self, timing: BitTiming, at: Fine) {
        *self = BitClock::new(timing, at);
        self.synchronised = true;
    }

    /// Advances over `edges`, which arrive `delay` late, and then `rest` bits without one; the last edge is recessive.
    /// Returns `None` if a sample would be outside its bit.
    ///
    /// This is the arithmetic of [`BitClock::dominant_edge`] for a receiver that sees only edges of one transmitter: a
    /// sample point lies between any two of them.
    pub(in crate::wire) fn follow(mut self, edges: &[Edge], delay: Fine, rest: u64) -> Option<BitClock> {
        if self.latched.is_some() {
            return None;
        }
        let (quantum, bit) = (self.timing.quantum.0.0, self.bit.0);
        let jump = quantum * u64::from(self.timing.jump_width);
        let to_sample = quantum * (1 + u64::from(self.timing.segment1));
        let (mut start, mut sample, mut end) = (self.start.0, self.sample.0, self.end.0);
        for edge in edges {
            let at = edge.at.0 + delay.0;
            if edge.bits > 1 {
                start = end + (edge.bits - 2) * bit;
                (sample, end) = (start + to_sample, start + bit);
            }
            if at < end {
                if at <= sample {
                    return None;
                }
                start = if edge.level { end } else { end - whole_quanta(end - at, quantum, jump) };
                (sample, end) = (start + to_sample, start + bit);
            } else {
                start = end;
                (sample, end) = (start + to_sample, start + bit);
                if at > sample {
                    return None;
                }
                if !edge.level {
                    let stretch = whole_quanta((at - start + 1).saturating_sub(quantum), quantum, jump);
                    (sample, end) = (sample + stretch, end + stretch);
                }
            }
            if at > sample {
                return None;
            }
        }
        if rest > 0 {
            start = end + (rest - 1) * bit;
            (sample, end) = (start + to_sample, start + bit);
        }
        (self.start, self.sample, self.end) = (Fine(start), Fine(sample), Fine(end));
        (self.synchronised, self.previous) = (false, true);
        Some(self)
    }
}

/// `span` rounded up to whole quanta, at most `most`.
fn whole_quanta(span: u64, quantum: u64, most: u64) -> u64 {
    let mut quanta = 0;
    while quanta < span && quanta < most {
        quanta += quantum;
    }
    quanta
}
