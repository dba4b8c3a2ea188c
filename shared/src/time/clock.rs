//! Local clock: the spacecraft time at every instant of this node, disciplined by pairs.
//!
//! A *pair* is an instant of the node and the spacecraft time at that instant. [`LocalClock::discipline`] predicts
//! the pair with a Kalman filter of offset, rate and drift (`estimator.rs`), and corrects the difference with the
//! gains of the filter. The result is a parabola, the best estimate of spacecraft time. The clock joins this
//! parabola in a straight line within 31 ms. It takes longer if it would otherwise run more than 0.1 % fast or
//! slow. `trust.rs` bounds the error, and `doubt.rs` decides about pairs outside of this bound.

use super::doubt::{Agreement, Doubt, Verdict};
use super::estimator::{Covariance, PLACES, SHIFT, State, advance, elapsed, limited, scale};
use super::policy::{ClockPolicy, Limits, ramp};
use super::quality::{Quality, Step, TimeSource};
use super::trust::{Trust, rate_of};
use crate::types::{FineInstant, FineScet};

/// Spacecraft time as a function of the time of the node.
///
/// From the instant `base` on it is the parabola of the filter plus a residue that goes to zero. Before, it is a
/// straight line of the same slope.
#[doc(alias("SCET", "spacecraft elapsed time", "local time"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LocalClock {
    limits: Limits,
    /// Instant at which the parabola starts.
    base: FineInstant,
    /// Its value there.
    scet: FineScet,
    /// Its slope there, less one. 2^-40.
    rate: i32,
    /// Change of the slope per second. 2^-48.
    drift: i32,
    /// Difference between the clock and the parabola at `base`, units of 2^-32 s.
    residue: i64,
    /// Rate at which the residue decreases. 2^-40, of its sign.
    slew: i32,
    /// Instant of the last pair or command, to which the covariance belongs.
    heard: FineInstant,
    known: Covariance,
    trust: Trust,
    doubt: Doubt,
    /// Binary places of a second in received times.
    fine_bits: u8,
    /// Weight of the pairs in a row that the filter did not expect, negative when the last one was behind the clock.
    unexpected: i8,
    source: TimeSource,
    /// There was a pair since power-on.
    is_synchronised: bool,
    steps: u16,
    refused: u16,
}

/// What a clock shows the time by, between two pairs or commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Course {
    pub base: FineInstant,
    pub scet: FineScet,
    pub rate: i32,
    pub drift: i32,
    pub residue: i64,
    pub slew: i32,
    pub heard: FineInstant,
    pub source: TimeSource,
    pub steps: u16,
}

impl Course {
    /// Returns in how many numbers it differs from another one.
    pub fn differences(&self, other: &Course) -> usize {
        let differs = [
            self.base != other.base,
            self.scet != other.scet,
            self.rate != other.rate,
            self.drift != other.drift,
            self.residue != other.residue,
            self.slew != other.slew,
            self.heard != other.heard,
            self.source != other.source,
            self.steps != other.steps,
        ];
        differs.into_iter().filter(|differs| *differs).count()
    }
}

/// A pair that differs from the clock by more than this steps it: 10 ms, in units of 2^-32 s.
pub(super) const STEP_LIMIT: u64 = 42_949_673;

/// The filter does not expect a pair that is off by more than this many standard deviations: it is an outlier, or a
/// crystal that changes its rate.
const GATE: i64 = 5;

/// Weight of an unexpected pair on the side of the one before; another one has a weight of 1.
const ON_ONE_SIDE: i8 = 2;

/// Multiple of the profile's largest rate at which contradicting pairs may agree with each other. A rate above the
/// largest saturates the clock.
const OTHER_RATES: i64 = 4;

/// Time without a pair after which rate and drift are found anew: 64 s, in units of 2^-32 s.
const FORGOTTEN: i64 = 64 << 32;

/// Most that the parabola may begin in the future: a second, more than the delays by which pairs are corrected.
const AHEAD: i64 = 1 << 32;

/// Most that the filter takes for a drift: 3.8 ppm/s. 2^-48.
const DRIFT_LIMIT: i32 = 1 << 30;

/// The residue goes no faster than 2^-10. 2^-40.
const SLEW_LIMIT: i32 = 1 << 30;

impl Default for LocalClock {
    fn default() -> Self {
        Self::new(&ClockPolicy::DEFAULT)
    }
}

impl LocalClock {
    /// Makes a clock that counts from zero at the instant zero, at the nominal rate, until it is set.
    pub const fn new(policy: &ClockPolicy) -> Self {
        let limits = policy.limits();
        LocalClock {
            base: FineInstant::from_units(0),
            scet: FineScet::from_units(0),
            rate: 0,
            drift: 0,
            residue: 0,
            slew: 0,
            heard: FineInstant::from_units(0),
            known: Covariance::fresh(TimeSource::None.variance()),
            trust: Trust::new(&limits),
            doubt: Doubt::new(),
            fine_bits: 24,
            unexpected: 0,
            source: TimeSource::None,
            is_synchronised: false,
            steps: 0,
            refused: 0,
            limits,
        }
    }

    /// Sets the number of binary places of a second in times that are received from now on (7.1.2g). The default
    /// is 24. Numbers below 8 count as 8.
    pub const fn set_fine_bits(&mut self, bits: u32) {
        self.fine_bits = if bits < 8 {
            8
        } else if bits > 24 {
            24
        } else {
            bits as u8
        };
    }

    /// Returns whether the clock was set. Before, it counts from power-on.
    pub fn is_set(&self) -> bool {
        self.source != TimeSource::None
    }

    /// Returns whether the clock follows spacecraft times: one arrived since power-on.
    pub(crate) const fn is_synchronised(&self) -> bool {
        self.is_synchronised
    }

    /// Sets the clock by command: at the instant `at` the spacecraft time is `scet`. This is always a step. The
    /// known rate stays.
    pub fn set(&mut self, at: FineInstant, scet: FineScet) -> Step {
        // From one command to the next there is nothing new to be known of the rate.
        let span =
            if self.source == TimeSource::Command { 0 } else { elapsed(self.heard, at).min(FORGOTTEN) };
        self.known.replace_offset(TimeSource::Command.variance(), span);
        self.step(at, scet, TimeSource::Command)
    }

    /// Takes a pair: at the instant `at` the spacecraft time was `scet`, corrected by constant delays and by the
    /// mean of the truncation. `now` is the present; no later instant was read yet. Returns the step if there was
    /// one: at the first pair, or when enough pairs agree that the clock is wrong by more than 10 ms. Ignores the
    /// pair if `at` is not later than the last `now`.
    pub fn discipline(
        &mut self,
        at: FineInstant,
        scet: FineScet,
        source: TimeSource,
        now: FineInstant,
    ) -> Option<Step> {
        if self.is_over(at) {
            return None;
        }
        let noise = source.variance() + self.quantum();
        if !self.is_synchronised {
            self.is_synchronised = true;
            self.known = Covariance::fresh(noise);
            return Some(self.step(at, scet, source));
        }
        let off = scet.since(self.at(at));
        let error = off.wrapping_add(self.residue_at(at));
        let silence = elapsed(self.heard, at);
        let uncertain = self.error(source);
        let contradicts = error.unsigned_abs() > (self.reach(silence) + uncertain) as u64;
        let change = if contradicts {
            self.contradicted(at, error, silence, noise, 2 * uncertain)
        } else {
            self.doubt.agreed();
            self.filtered(error, silence, source, noise)
        };
        let Some(change) = change else {
            self.refused = self.refused.wrapping_add(1);
            return None;
        };
        if off.unsigned_abs() > STEP_LIMIT {
            let step = self.step(at, scet, source);
            self.turn(change);
            return Some(step);
        }
        if contradicts || source != self.source {
            self.trust.set(at, scet, silence, &self.limits);
        } else {
            self.trust.measure(at, scet, silence, uncertain, &self.limits);
        }
        let [offset, ..] = change;
        self.trust.off = error - offset;
        self.correct(at, change, now.max(at));
        self.taken(at, source);
        None
    }

    /// Returns what the clock shows the time by.
    pub(super) const fn course(&self) -> Course {
        let LocalClock { base, scet, rate, drift, residue, slew, heard, source, steps, .. } = *self;
        Course { base, scet, rate, drift, residue, slew, heard, source, steps }
    }

    /// Takes a course again.
    pub(super) const fn restore(&mut self, course: &Course) {
        (self.base, self.scet, self.rate, self.drift) = (course.base, course.scet, course.rate, course.drift);
        (self.residue, self.slew, self.heard) = (course.residue, course.slew, course.heard);
        (self.source, self.steps) = (course.source, course.steps);
    }

    /// Forgets the clock if its parabola begins in the future: a bit of that instant flipped. Then the pair of the instant `at` sets
    /// it. Without this all pairs until that instant would be too late.
    pub(crate) fn confine(&mut self, at: FineInstant, now: FineInstant) {
        if elapsed(now, self.base) > AHEAD {
            (self.base, self.is_synchronised) = (at, false);
        }
    }

    /// Returns whether the clock was corrected after the instant `at`. A pair of that instant is ignored.
    pub(crate) fn is_over(&self, at: FineInstant) -> bool {
        at < self.base
    }

    /// Correction by a pair that contradicts the clock, if it moves the clock; `uncertain` is what two pairs may be
    /// off.
    fn contradicted(
        &mut self,
        at: FineInstant,
        error: i64,
        silence: i64,
        noise: i64,
        uncertain: i64,
    ) -> Option<State> {
        let (beyond, span) = (self.doubt.beyond(error), elapsed(self.doubt.at, at));
        let is_within = |rate| {
            let growth = Trust::growth(rate, span, &self.limits);
            beyond.unsigned_abs() <= (uncertain + growth) as u64
        };
        let agreement = if is_within(self.trust.rate_error(self.rate)) {
            Agreement::AtRate
        } else if is_within(OTHER_RATES * i64::from(self.limits.rate)) {
            Agreement::AtOtherRate
        } else {
            Agreement::None
        };
        match self.doubt.contradicted(at, error, agreement, self.limits.agreeing) {
            Verdict::Refused => None,
            Verdict::Moves => {
                self.known.replace_offset(noise * 16, silence.min(FORGOTTEN));
                Some([error, 0, 0])
            }
            Verdict::MovesAtOtherRate => {
                self.known = Covariance::fresh(noise);
                self.trust.forget_rate(&self.limits);
                Some([error, rate_of(beyond, span), 0])
            }
        }
    }

    /// Correction of the filter by a pair; none for an outlier.
    fn filtered(&mut self, error: i64, silence: i64, source: TimeSource, noise: i64) -> Option<State> {
        if silence > FORGOTTEN {
            self.known = Covariance::fresh(noise);
            return Some([error, 0, 0]);
        }
        let mut known = self.known.after(silence);
        if error.abs() > GATE * i64::from(known.deviation(noise)) {
            if !self.count_unexpected(error, source) {
                return None;
            }
            self.known = Covariance::fresh(noise);
            return Some([error, 0, 0]);
        }
        let [offset, rate, drift] = known.update(noise);
        self.known = known;
        Some([scale(error, offset), scale(error << 8, rate), scale(error << 16, drift)])
    }

    /// Returns whether enough pairs that the filter did not expect came in a row; this one is off by `error`.
    fn count_unexpected(&mut self, error: i64, source: TimeSource) -> bool {
        let side = if error < 0 { -1 } else { 1 };
        let weight = self.unexpected.abs() + if self.unexpected * side > 0 { ON_ONE_SIDE } else { 1 };
        self.unexpected = weight * side;
        weight >= source.outliers()
    }

    /// Largest error of the parabola, `silence` after the last pair, units of 2^-32 s.
    fn reach(&self, silence: i64) -> i64 {
        let growth = Trust::growth(self.trust.rate_error(self.rate), silence, &self.limits);
        let extrapolated = ramp(i64::from(self.drift >> SHIFT).abs(), self.limits.ramp, silence);
        self.trust.off.abs() + self.error(self.source) + growth + extrapolated
    }

    /// Most that a pair is off, units of 2^-32 s.
    fn error(&self, source: TimeSource) -> i64 {
        source.error() + (1 << (31 - self.fine_bits))
    }

    /// Variance of the quantum of received times: a uniform error, corrected by its mean.
    fn quantum(&self) -> i64 {
        ((1_i64 << (64 - 2 * self.fine_bits)) / 12) << PLACES
    }

    /// Returns the spacecraft time at an instant, also before the last correction or after the present.
    pub fn at(&self, at: FineInstant) -> FineScet {
        if at < self.base {
            let ago = elapsed(at, self.base);
            self.scet.plus(self.residue - ago - scale(ago >> 8, self.rate.into()))
        } else {
            self.parabola(at).0.plus(self.residue_at(at))
        }
    }

    /// Returns the first instant at which [`at`](Self::at) returns `scet` or more, in the nearer half of the
    /// counter's range. The instant is in the past if that time has passed. It is power-on if the time was before
    /// it.
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

    /// Returns the quality of the clock at the instant `now`.
    pub fn quality(&self, now: FineInstant) -> Quality {
        let silence = elapsed(self.heard, now);
        let differs = self.residue_at(now).abs() + self.doubt.widens();
        let bound = scale(self.reach(silence) + differs, 1_000_000_000) + i64::from(self.source.systematic());
        let is_unknown = self.source == TimeSource::None || self.is_saturated();
        Quality {
            bound_ns: if is_unknown { u32::MAX } else { saturated(bound) },
            source: self.source,
            age_ms: saturated(scale(silence, 1_000)),
            rate_ppb: scale(self.parabola(now).1, 1_000_000_000 >> SHIFT) as i32,
            steps: self.steps,
            refused: self.refused,
        }
    }

    /// Returns whether the rate is at the limit that the profile sets for its crystals. Then the clock may be
    /// unable to follow.
    pub const fn is_saturated(&self) -> bool {
        self.rate.abs() >= self.limits.rate
    }

    /// Returns the number of pairs refused because they did not agree with the others. It wraps.
    pub const fn refused(&self) -> u16 {
        self.refused
    }

    /// The parabola goes through `scet` at the instant `at`, without a residue.
    fn step(&mut self, at: FineInstant, scet: FineScet, source: TimeSource) -> Step {
        let from = self.at(at).scet();
        self.trust.set(at, scet, elapsed(self.heard, at), &self.limits);
        self.move_base(at);
        (self.scet, self.residue, self.slew) = (scet, 0, 0);
        self.steps = self.steps.wrapping_add(1);
        self.taken(at, source);
        Step { from, to: scet.scet() }
    }

    /// The parabola changes at the instant `at` by an offset, a rate and a drift. What the clock shows does not, at
    /// `now`.
    fn correct(&mut self, at: FineInstant, change: State, now: FineInstant) {
        let shown = self.at(now);
        self.move_base(at);
        let [offset, ..] = change;
        self.scet = self.scet.plus(offset);
        self.turn(change);
        self.move_base(now);
        self.residue = shown.since(self.scet);
        self.slew = limited(self.residue << 13, SLEW_LIMIT);
    }

    /// Rate (2^-40) and drift (2^-48) change at the base.
    fn turn(&mut self, [_, rate, drift]: State) {
        self.rate = limited(i64::from(self.rate).saturating_add(rate), self.limits.rate);
        self.drift = limited(i64::from(self.drift) + drift, DRIFT_LIMIT);
    }

    fn taken(&mut self, at: FineInstant, source: TimeSource) {
        (self.heard, self.source, self.unexpected) = (at, source, 0);
    }

    /// The same parabola, from another instant on.
    fn move_base(&mut self, to: FineInstant) {
        let (scet, rate) = self.parabola(to);
        (self.base, self.scet, self.rate) = (to, scet, limited(rate, self.limits.rate));
    }

    /// Best guess of spacecraft time, and its slope, less one. 2^-40. From the base on.
    fn parabola(&self, at: FineInstant) -> (FineScet, i64) {
        let span = elapsed(self.base, at);
        // The excursion of the crystals ends, and with it their drift.
        let drifting = span.min(self.limits.ramp);
        let mut state = [span, self.rate.into(), self.drift.into()];
        advance(&mut state, drifting >> 8);
        let [offset, rate, _] = state;
        (self.scet.plus(offset + scale((span - drifting) >> 8, rate)), rate)
    }

    /// Returns the rest of the residue, in units of 2^-32 s.
    fn residue_at(&self, at: FineInstant) -> i64 {
        let left = self.residue.wrapping_sub(scale(elapsed(self.base, at) >> 8, self.slew.into()));
        // Of the other sign: it has gone to zero.
        if (left ^ self.residue) < 0 { 0 } else { left }
    }
}

/// Units of [`FineInstant`] in a second.
const UNITS_PER_SECOND: i64 = FineInstant::PER_MICRO as i64 * 1_000_000;

/// Converts to a `u32`. A larger value becomes `u32::MAX`.
fn saturated(value: i64) -> u32 {
    value.min(u32::MAX.into()) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a clock that takes a pair each second, when any bit of its parabola flips, then it is right again after ten pairs.
    #[test]
    fn flipped_bit_of_the_parabola_is_over_after_ten_pairs() {
        let at = |second: u64| FineInstant::from_units(second * UNITS_PER_SECOND as u64);
        let scet = |second: u64| FineScet::from_units((1_000 + second) << 32);
        let pair = |clock: &mut LocalClock, second| {
            let now = at(second).plus(UNITS_PER_SECOND / 1_000);
            clock.confine(at(second), now);
            clock.discipline(at(second), scet(second), TimeSource::Capture, now);
        };
        let mut sound = LocalClock::new(&ClockPolicy::DEFAULT);
        (1..20).for_each(|second| pair(&mut sound, second));
        let flips: [fn(&mut LocalClock, u32); 7] = [
            |clock, bit| clock.base = FineInstant::from_units(clock.base.units() ^ 1 << bit),
            |clock, bit| clock.scet = FineScet::from_units(clock.scet.units() ^ 1 << bit),
            |clock, bit| clock.heard = FineInstant::from_units(clock.heard.units() ^ 1 << bit),
            |clock, bit| clock.residue ^= 1 << bit,
            |clock, bit| clock.rate ^= 1 << (bit % 32),
            |clock, bit| clock.drift ^= 1 << (bit % 32),
            |clock, bit| clock.slew ^= 1 << (bit % 32),
        ];
        for (field, flip) in flips.iter().enumerate() {
            for bit in 0..64 {
                let mut clock = sound.clone();
                flip(&mut clock, bit);
                (20..30).for_each(|second| pair(&mut clock, second));
                let off = clock.at(at(30)).since(scet(30)).unsigned_abs();
                assert!(off < STEP_LIMIT, "field {field}, bit {bit}: {off}");
            }
        }
    }
}
