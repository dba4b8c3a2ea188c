//! The local clock: spacecraft time at every instant of this node, disciplined by pairs of both.
//!
//! A pair says: at this instant of the node it was this spacecraft time. [`LocalClock::discipline`] predicts the pair with a
//! Kalman filter of offset, rate and drift (`estimator.rs`), and takes the difference with the gains of the filter. What it
//! finds is a parabola, the best guess of spacecraft time. The clock itself joins it in a straight line within 31 ms, or
//! more slowly so that it never runs more than 0.1 % fast or slow for it.

use super::estimator::{Covariance, Gains, MOST, PLACES, scale};
use super::quality::{Quality, Step, TimeSource};
use super::span::{PER_SECOND, Span};
use crate::types::{FineInstant, FineScet};

/// Spacecraft time as a function of the node's own.
///
/// From the instant `base` on it is the parabola of the filter, plus a residue that goes to zero. Before, it is a straight
/// line: what the clock showed lately.
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
    /// Slope of the clock before `base`, less one. 2^-40.
    before: i32,
    /// Instant of the last pair or command, to which the covariance belongs.
    heard: FineInstant,
    known: Covariance,
    /// Variance of the quantum of received times.
    quantum: i64,
    /// What the last pair that was refused differed by, units of 2^-32 s.
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
const STEP_LIMIT: u64 = 42_949_673;

/// A pair is refused that is off by more than this many standard deviations.
const GATE: u64 = 5;

/// Standard deviations in the reported bound.
const SURE: u64 = 5;

/// Three refused pairs in a row that agree, or seven that do not, show that the clock is wrong.
const CONVINCED: u8 = 7;
const AGREES: u8 = 3;

/// Time without a pair after which rate and drift are found anew: 64 s, in units of 2^-32 s.
const FORGOTTEN: u64 = 64 << 32;

/// Time for which the drift is extrapolated, as crystals do not drift on for ever: 128 s, in units of 2^-32 s.
const HORIZON: u64 = 128 << 32;

/// No two crystals differ by more: 200 ppm. 2^-40.
const RATE_LIMIT: i64 = 219_902_325;

/// No temperature changes two crystals faster: 1 ppm/s. 2^-48.
const DRIFT_LIMIT: i64 = 281_474_976;

/// The covariance represents deviations below this: 0.5 ms, in units of 2^-32 s.
const REPRESENTED: u32 = 1 << 21;

/// What rate, drift until the horizon and the crystals themselves can come to is less than 2^-11 (488 ppm).
const WORST_RATE: u32 = 11;

/// The residue goes no faster than 2^-10. 2^-40.
const SLEW_LIMIT: i64 = 1 << 30;

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
            before: 0,
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

    /// Received times have this many binary places of a second (7.1.2g): 24 when this was not called; fewer than 8 count as 8.
    #[must_use]
    pub const fn fine_bits(mut self, bits: u32) -> Self {
        self.quantum = quantum(bits);
        self
    }

    /// It is `scet` at the instant `at`, by command. Always a step. What is known of the rate stays known.
    pub fn set(&mut self, at: FineInstant, scet: FineScet) -> Step {
        self.known = self.known.after(self.silence(at).min(HORIZON) as i64);
        self.known.replace_offset(TimeSource::Command.variance());
        self.step(at, scet, TimeSource::Command)
    }

    /// A pair: at the instant `at` it was `scet`. Constant delays and the mean of the truncation are corrected in it. `now`
    /// is the present: no later instant was asked for yet. Returns the step when there was one: at the first pair, and
    /// when the clock was wrong by more than 10 ms. A pair older than the last one is ignored.
    pub fn discipline(
        &mut self,
        at: FineInstant,
        scet: FineScet,
        source: TimeSource,
        now: FineInstant,
    ) -> Option<Step> {
        if at < self.heard {
            return None;
        }
        let noise = source.variance() + self.quantum;
        if !self.is_synchronised || scet.since(self.at(at)).unsigned_abs() > STEP_LIMIT {
            self.is_synchronised = true;
            self.known = Covariance::fresh(noise);
            return Some(self.step(at, scet, source));
        }
        let silence = self.silence(at);
        let error = scet.since(self.parabola(at));
        let mut known = self.known.after(silence.min(FORGOTTEN) as i64);
        let gate = GATE * u64::from(known.deviation(noise));
        let mut gains = Gains::OFFSET;
        if silence > FORGOTTEN {
            known = Covariance::fresh(noise);
        } else if error.unsigned_abs() <= gate {
            gains = known.update(noise);
        } else {
            let agrees = self.doubt > 0 && error.saturating_sub(self.suspect).unsigned_abs() <= gate;
            (self.suspect, self.refused) = (error, self.refused.wrapping_add(1));
            self.doubt += if agrees { AGREES } else { 1 };
            if self.doubt < CONVINCED {
                return None;
            }
            known = Covariance::fresh(noise);
        }
        self.known = known;
        self.correct(at, error, &gains, now.max(at));
        self.taken(at, source);
        None
    }

    /// Spacecraft time at an instant, also before the last correction, or after the present.
    pub fn at(&self, at: FineInstant) -> FineScet {
        if at < self.base {
            let shown = plus(self.scet, self.residue);
            let ago = Span::between(at, self.base);
            plus(shown, (ago.advance(self.before.into(), 0) as i64).wrapping_neg())
        } else {
            let since = Span::between(self.base, at);
            plus(self.parabola(at), self.residue_after(since))
        }
    }

    /// The first instant at which [`at`](Self::at) gives `scet` or more, the shorter way round the counter. In the past when
    /// that time has passed; power-on when it was before.
    pub fn when(&self, scet: FineScet) -> FineInstant {
        let mut at = self.base;
        // Each turn leaves a thousandth of the distance.
        for _ in 0..8 {
            let passed = self.at(at).since(scet);
            let back = scale(passed, PER_SECOND as i64);
            if back == 0 {
                break;
            }
            at = FineInstant::from_units(at.units().saturating_add_signed(-back));
        }
        let before = FineInstant::from_units(at.units().saturating_sub(1));
        if self.at(before).since(scet) >= 0 { before } else { at }
    }

    /// How far the clock can be trusted at the instant `now`.
    pub fn quality(&self, now: FineInstant) -> Quality {
        let silence = self.silence(now);
        let extrapolated = silence.min(HORIZON);
        let deviation = self.known.after(extrapolated as i64).deviation(0);
        let filter = if deviation < REPRESENTED { u64::from(deviation) * SURE } else { u64::MAX };
        let worst = u64::from(self.known.deviation(0)) * SURE + (extrapolated >> WORST_RATE);
        let residue = self.residue_after(Span::between(self.base, now.max(self.base)));
        let units = filter.min(worst) + ((silence - extrapolated) >> WORST_RATE) + residue.unsigned_abs();
        let bound_ns = match self.source {
            TimeSource::None => u32::MAX,
            source => nanoseconds(units).saturating_add(source.systematic()),
        };
        let age_ms = now.units().saturating_sub(self.heard.units()) / (FineInstant::PER_MICRO * 1_000);
        Quality {
            bound_ns,
            source: self.source,
            age_ms: u32::try_from(age_ms).unwrap_or(u32::MAX),
            rate_ppb: ((self.slope(now) * 1_000_000_000) >> 40) as i32,
            steps: self.steps,
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
        (self.scet, self.residue, self.slew, self.before) = (scet, 0, 0, self.rate);
        self.steps = self.steps.wrapping_add(1);
        self.taken(at, source);
        Step { from, to: scet.scet() }
    }

    /// The parabola changes by `gains` of `error` at the instant `at`. What the clock shows does not, at the instant `now`.
    fn correct(&mut self, at: FineInstant, error: i64, gains: &Gains, now: FineInstant) {
        let shown = self.at(now);
        let slewing = if self.residue_after(Span::between(self.base, now)) == 0 { 0 } else { self.slew };
        let before = self.slope(now) - i64::from(slewing);
        self.move_base(at);
        self.scet = plus(self.scet, scale(error, gains.offset));
        self.rate = limited(i64::from(self.rate) + scale(error << 8, gains.rate), RATE_LIMIT);
        self.drift = limited(i64::from(self.drift) + scale(error << 16, gains.drift), DRIFT_LIMIT);
        self.move_base(now);
        self.before = limited(before, i32::MAX.into());
        self.residue = shown.since(self.scet);
        self.slew = limited(self.residue << 13, SLEW_LIMIT);
    }

    fn taken(&mut self, at: FineInstant, source: TimeSource) {
        (self.heard, self.source, self.doubt) = (at, source, 0);
    }

    /// The same parabola, from another instant on.
    fn move_base(&mut self, to: FineInstant) {
        (self.scet, self.rate) = (self.parabola(to), limited(self.slope(to), RATE_LIMIT));
        self.base = to;
    }

    /// Best guess of spacecraft time.
    fn parabola(&self, at: FineInstant) -> FineScet {
        let (rate, drift) = (i64::from(self.rate), i64::from(self.drift));
        if at < self.base {
            let ago = Span::between(at, self.base).advance(rate, -drift);
            plus(self.scet, (ago as i64).wrapping_neg())
        } else {
            plus(self.scet, Span::between(self.base, at).advance(rate, drift) as i64)
        }
    }

    /// Slope of the parabola, less one. 2^-40.
    fn slope(&self, at: FineInstant) -> i64 {
        let drift = self.drift.into();
        let gained = if at < self.base {
            -Span::between(at, self.base).gained(drift)
        } else {
            Span::between(self.base, at).gained(drift)
        };
        i64::from(self.rate) + gained
    }

    /// What is left of the residue, units of 2^-32 s.
    fn residue_after(&self, since: Span) -> i64 {
        let gone = since.times(self.slew.into());
        if gone.unsigned_abs() >= self.residue.unsigned_abs() { 0 } else { self.residue - gone }
    }

    /// Time since the last pair or command, units of 2^-32 s.
    fn silence(&self, at: FineInstant) -> u64 {
        Span::between(self.heard, at).units()
    }
}

/// Variance of times that were cut to so many binary places: a uniform error, corrected by its mean.
const fn quantum(bits: u32) -> i64 {
    let bits = if bits < 8 {
        8
    } else if bits > 24 {
        24
    } else {
        bits
    };
    let variance = (1_i64 << (64 - 2 * bits)) / 12;
    if variance > MOST >> PLACES { MOST } else { variance << PLACES }
}

/// Later by units of 2^-32 s, or earlier.
const fn plus(scet: FineScet, units: i64) -> FineScet {
    FineScet::from_units(scet.units().wrapping_add_signed(units))
}

/// `value`, at most `limit` either way.
fn limited(value: i64, limit: i64) -> i32 {
    value.clamp(-limit, limit) as i32
}

/// Of units of 2^-32 s, saturating.
fn nanoseconds(units: u64) -> u32 {
    let ns = (units.min(1 << 35) * 125_000_000) >> 29;
    u32::try_from(ns).unwrap_or(u32::MAX)
}
