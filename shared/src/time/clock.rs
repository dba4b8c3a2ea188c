//! The local clock: spacecraft time at every instant of this node, disciplined by pairs of both.
//!
//! A pair says: at this instant of the node it was this spacecraft time. [`LocalClock::discipline`] predicts the pair with a
//! Kalman filter of offset, rate and drift (`estimator.rs`), and takes the difference with the gains of the filter. What it
//! finds is a parabola, the best guess of spacecraft time. The clock itself joins it in a straight line within 31 ms, or
//! more slowly so that it never runs more than 0.1 % fast or slow for it.

use super::estimator::{Covariance, Gains, PLACES, advance, scale};
use super::quality::{Quality, Step, TimeSource};
use crate::types::{FineInstant, FineScet};

/// Spacecraft time as a function of the node's own.
///
/// From the instant `base` on it is the parabola of the filter, plus a residue that goes to zero. Before, it is a straight
/// line of the same slope.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LocalClock {
    /// Where the parabola starts.
    base: FineInstant,
    /// Its value there.
    scet: FineScet,
    /// Its slope there, less one. 2^-40.
    rate: i32,
    /// Change of the slope per second. 2^-48.
    drift: i32,
    /// What the clock shows at `base` above the parabola, units of 2^-32 s.
    residue: i64,
    /// How fast the residue goes. 2^-40, of its sign.
    slew: i32,
    /// Instant of the last pair or command, to which the covariance belongs.
    heard: FineInstant,
    known: Covariance,
    /// Variance of the quantum of received times.
    quantum: i64,
    /// What the last pair differed by when it was refused, else zero, units of 2^-32 s.
    suspect: i64,
    /// Counts to [`CONVINCED`] while pairs are refused.
    doubt: u8,
    source: TimeSource,
    /// There was a pair since power-on.
    is_synchronised: bool,
    steps: u16,
    refused: u16,
}

/// A pair that differs from the clock by more than this steps it: 10 ms, in units of 2^-32 s.
pub(super) const STEP_LIMIT: u64 = 42_949_673;

/// A pair is refused that is off by more than this many standard deviations.
const GATE: i64 = 5;

/// Standard deviations in the reported bound.
const SURE: i64 = 6;

/// Four refused pairs in a row on one side, or at most seven on both, show that it is the clock that is wrong.
const CONVINCED: u8 = 7;
const AGREES: u8 = 2;

/// Time without a pair after which rate and drift are found anew: 64 s, in units of 2^-32 s.
const FORGOTTEN: i64 = 64 << 32;

/// Time for which the drift is extrapolated, as crystals do not drift on for ever: 128 s, in units of 2^-32 s.
const HORIZON: i64 = 128 << 32;

/// No two crystals differ by more: 200 ppm. 2^-40.
const RATE_LIMIT: i32 = 219_902_325;

/// No temperature changes two crystals faster: 1 ppm/s. 2^-48.
const DRIFT_LIMIT: i32 = 281_474_976;

/// The covariance represents deviations below this: 8 ms, in units of 2^-32 s.
const REPRESENTED: u32 = 1 << 25;

/// What rate, drift until the horizon and the crystals themselves can come to is less than 2^-11 (488 ppm).
const WORST_RATE: u32 = 11;

/// The residue goes no faster than 2^-10. 2^-40.
const SLEW_LIMIT: i32 = 1 << 30;

impl Default for LocalClock {
    fn default() -> Self {
        Self::new()
    }
}

impl LocalClock {
    /// Counts from zero at the instant zero, at the nominal rate, until it is set.
    pub const fn new() -> Self {
        LocalClock {
            base: FineInstant::from_units(0),
            scet: FineScet::from_units(0),
            rate: 0,
            drift: 0,
            residue: 0,
            slew: 0,
            heard: FineInstant::from_units(0),
            known: Covariance::fresh(TimeSource::None.variance()),
            quantum: quantum(24),
            suspect: 0,
            doubt: 0,
            source: TimeSource::None,
            is_synchronised: false,
            steps: 0,
            refused: 0,
        }
    }

    /// Times that are received from now on have this many binary places of a second (7.1.2g): 24 when this was not called; fewer
    /// than 8 count as 8.
    pub const fn set_fine_bits(&mut self, bits: u32) {
        self.quantum = quantum(bits);
    }

    /// Whether it was set: it does not count from power-on any more.
    pub fn is_set(&self) -> bool {
        self.source != TimeSource::None
    }

    /// It is `scet` at the instant `at`, by command. Always a step. What is known of the rate stays known.
    pub fn set(&mut self, at: FineInstant, scet: FineScet) -> Step {
        // From one command to the next there is nothing new to be known of the rate.
        let span = if self.source == TimeSource::Command { 0 } else { elapsed(self.heard, at).min(HORIZON) };
        self.known.replace_offset(TimeSource::Command.variance(), span);
        self.step(at, scet, TimeSource::Command)
    }

    /// A pair: at the instant `at` it was `scet`. Constant delays and the mean of the truncation are corrected in it. `now`
    /// is the present: no later instant was asked for yet. Returns the step when there was one: at the first pair, and
    /// when the clock was wrong by more than 10 ms. Ignored when `at` is not later than the last `now`.
    pub fn discipline(
        &mut self,
        at: FineInstant,
        scet: FineScet,
        source: TimeSource,
        now: FineInstant,
    ) -> Option<Step> {
        if at < self.base {
            return None;
        }
        let off = scet.since(self.at(at));
        let is_step = !self.is_synchronised || off.unsigned_abs() > STEP_LIMIT;
        let error = off.wrapping_add(self.residue_at(at));
        let silence = elapsed(self.heard, at);
        let noise = source.variance() + self.quantum;
        let mut known = self.known.after(silence.min(FORGOTTEN));
        let mut gains = [1 << 32, 0, 0];
        if is_step || silence > FORGOTTEN {
            known = Covariance::fresh(noise);
        } else {
            if error.abs() <= GATE * i64::from(known.deviation(noise)) {
                gains = known.update(noise);
            } else if self.is_convinced(error) {
                known = Covariance::fresh(noise);
            } else {
                return None;
            }
        }
        self.known = known;
        if is_step {
            self.is_synchronised = true;
            return Some(self.step(at, scet, source));
        }
        self.correct(at, error, gains, now.max(at));
        self.taken(at, source);
        None
    }

    /// A pair differs too much. Whether it is the clock that is wrong.
    fn is_convinced(&mut self, error: i64) -> bool {
        self.refused = self.refused.wrapping_add(1);
        self.doubt += if self.doubt > 0 && (error ^ self.suspect) >= 0 { AGREES } else { 1 };
        self.suspect = error;
        self.doubt >= CONVINCED
    }

    /// Spacecraft time at an instant, also before the last correction, or after the present.
    pub fn at(&self, at: FineInstant) -> FineScet {
        if at < self.base {
            let ago = elapsed(at, self.base);
            self.scet.plus(self.residue - ago - scale(ago >> 8, self.rate.into()))
        } else {
            self.parabola(at).0.plus(self.residue_at(at))
        }
    }

    /// The first instant at which [`at`](Self::at) gives `scet` or more, the shorter way round the counter. In the past when
    /// that time has passed; power-on when it was before.
    pub fn when(&self, scet: FineScet) -> FineInstant {
        // By the rate: what this is off by comes from the drift and the residue, and each turn leaves a thousandth of it. A turn
        // takes 700 cycles of an application (row `rx.inside_look`).
        let ahead = scet.since(self.scet);
        let ahead = ahead.wrapping_sub(scale(ahead >> 8, self.rate.into()));
        let mut at = self.base.units().saturating_add_signed(scale(ahead, UNITS_PER_SECOND));
        for _ in 0..8 {
            let passed = self.at(FineInstant::from_units(at)).since(scet);
            // The clock counts 15 to 18 units in one of its own: it is this one, or the next.
            match passed {
                0..15 => break,
                -15..0 => {
                    at = at.saturating_add(1);
                    break;
                }
                15.. => at = at.saturating_add_signed(-scale(passed, UNITS_PER_SECOND).max(1)),
                _ => at = at.saturating_add_signed(-scale(passed, UNITS_PER_SECOND)),
            }
        }
        FineInstant::from_units(at)
    }

    /// How far the clock can be trusted at the instant `now`.
    pub fn quality(&self, now: FineInstant) -> Quality {
        let silence = elapsed(self.heard, now);
        let extrapolated = silence.min(HORIZON);
        let deviation = self.known.after(extrapolated).deviation(0);
        let (deviation, worst) = if deviation < REPRESENTED {
            (deviation, silence - extrapolated)
        } else {
            (self.known.deviation(0), silence)
        };
        // While it is not decided who is wrong, it may be the clock.
        let differs = self.residue_at(now).abs() + self.suspect.abs();
        let units = SURE * i64::from(deviation) + (worst >> WORST_RATE) + differs;
        let bound = scale(units, 1_000_000_000) + i64::from(self.source.systematic());
        Quality {
            bound_ns: if self.source == TimeSource::None { u32::MAX } else { saturated(bound) },
            source: self.source,
            age_ms: saturated(scale(silence, 1_000)),
            rate_ppb: scale(self.parabola(now).1, 1_000_000_000 >> 8) as i32,
            steps: self.steps,
            refused: self.refused,
        }
    }

    /// Pairs that were refused because they did not agree with the others, wrapping.
    pub const fn refused(&self) -> u16 {
        self.refused
    }

    /// The parabola goes through `scet` at the instant `at`, without a residue.
    fn step(&mut self, at: FineInstant, scet: FineScet, source: TimeSource) -> Step {
        let from = self.at(at).scet();
        self.move_base(at);
        (self.scet, self.residue, self.slew) = (scet, 0, 0);
        self.steps = self.steps.wrapping_add(1);
        self.taken(at, source);
        Step { from, to: scet.scet() }
    }

    /// The parabola changes by `gains` of `error` at the instant `at`. What the clock shows does not, at the instant `now`.
    fn correct(&mut self, at: FineInstant, error: i64, gains: Gains, now: FineInstant) {
        let shown = self.at(now);
        self.move_base(at);
        let [offset, rate, drift] = gains;
        self.scet = self.scet.plus(scale(error, offset));
        self.rate = limited(i64::from(self.rate) + scale(error << 8, rate), RATE_LIMIT);
        self.drift = limited(i64::from(self.drift) + scale(error << 16, drift), DRIFT_LIMIT);
        self.move_base(now);
        self.residue = shown.since(self.scet);
        self.slew = limited(self.residue << 13, SLEW_LIMIT);
    }

    fn taken(&mut self, at: FineInstant, source: TimeSource) {
        (self.heard, self.source) = (at, source);
        (self.doubt, self.suspect) = (0, 0);
    }

    /// The same parabola, from another instant on.
    fn move_base(&mut self, to: FineInstant) {
        let (scet, rate) = self.parabola(to);
        (self.base, self.scet, self.rate) = (to, scet, limited(rate, RATE_LIMIT));
    }

    /// Best guess of spacecraft time, and its slope, less one. 2^-40. From the base on.
    fn parabola(&self, at: FineInstant) -> (FineScet, i64) {
        let span = elapsed(self.base, at);
        let drifting = span.min(HORIZON);
        let mut state = [span, self.rate.into(), self.drift.into()];
        advance(&mut state, drifting >> 8);
        let [offset, rate, _] = state;
        (self.scet.plus(offset + scale((span - drifting) >> 8, rate)), rate)
    }

    /// What is left of the residue, units of 2^-32 s.
    fn residue_at(&self, at: FineInstant) -> i64 {
        let left = self.residue - scale(elapsed(self.base, at) >> 8, self.slew.into());
        // Of the other sign: it has gone to zero.
        if (left ^ self.residue) < 0 { 0 } else { left }
    }
}

/// From an instant to a later one, in units of 2^-32 s, rounded down; none when it is the earlier one, 35 years at most.
#[inline(never)] // 128 bits on a chip of 32
fn elapsed(from: FineInstant, to: FineInstant) -> i64 {
    let units = to.units().saturating_sub(from.units()).min(1 << 58) as i64;
    units * 16 + ((i128::from(units) * i128::from(REST)) >> 63) as i64
}

/// 2^32 / 256,000,000 less 16, rounded up, 2^-63.
const REST: i64 = ((((1 << 24) - 16_000_000) << 63) / 1_000_000 + 1_i128) as i64;

/// Units of [`FineInstant`] in a second.
const UNITS_PER_SECOND: i64 = FineInstant::PER_MICRO as i64 * 1_000_000;

/// Variance of times that were cut to so many binary places: a uniform error, corrected by its mean.
const fn quantum(bits: u32) -> i64 {
    let bits = if bits < 8 {
        8
    } else if bits > 24 {
        24
    } else {
        bits
    };
    ((1_i64 << (64 - 2 * bits)) / 12) << PLACES
}

/// `value`, at most `limit` either way.
#[inline(never)] // three times
fn limited(value: i64, limit: i32) -> i32 {
    let limit = i64::from(limit);
    value.min(limit).max(-limit) as i32
}

/// What is too large is `u32::MAX`.
fn saturated(value: i64) -> u32 {
    value.min(u32::MAX.into()) as u32
}
