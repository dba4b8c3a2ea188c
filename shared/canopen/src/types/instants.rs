//! Instants of a field, shifted to the origin of canonical states.

use super::{Bus, Duration, Instant, PerBus};

impl Instant {
    /// The present in every [canonical](super::Canonical) state: 12 days. No age that has an effect is as long.
    pub const ORIGIN: Instant = Instant::from_micros(1 << 40);
}

/// Instants of a field of a state machine. [`Canonical`](super::Canonical) moves the present to [`Instant::ORIGIN`].
///
/// An instant whose age has no effect any more moves to the last one whose age has. So all later decisions stay the
/// same. [`Instant::NEVER`] stays.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no instant",
    label = "`due`, `age` and `grid` stand at an `Instant`, or at an `Option`, an array or a `PerBus` of instants"
)]
pub trait Instants {
    /// Replaces each instant by the one that the function returns for it.
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant);

    /// Shifts instants that are compared with now alone: all past ones are alike.
    fn due(&mut self, now: Instant) {
        self.age(now, Duration::ZERO);
    }

    /// Shifts instants whose age has an effect up to `horizon`: all older ones are alike.
    fn age(&mut self, now: Instant, horizon: Duration) {
        self.replace(&mut |at| aged(at, now, horizon));
    }

    /// Shifts points of a grid: a past one moves to the last one before now. A `period` of zero has one point.
    fn grid(&mut self, now: Instant, period: Duration) {
        self.replace(&mut |at| {
            let late = now.since(at).as_micros();
            let rest = late.checked_rem(period.as_micros()).unwrap_or(late);
            aged(at, now, Duration::from_micros(rest))
        });
    }
}

fn aged(at: Instant, now: Instant, horizon: Duration) -> Instant {
    if at == Instant::NEVER {
        at
    } else if at >= now {
        Instant::ORIGIN + at.since(now)
    } else {
        Instant::ORIGIN - now.since(at).min(horizon)
    }
}

impl Instants for Instant {
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant) {
        *self = function(*self);
    }
}

/// An instant, and the bus that it concerns.
impl Instants for (Instant, Bus) {
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant) {
        self.0.replace(function);
    }
}

impl<I: Instants> Instants for Option<I> {
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant) {
        self.iter_mut().for_each(|instants| instants.replace(function));
    }
}

impl<I: Instants> Instants for PerBus<I> {
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant) {
        self.nominal.replace(function);
        self.redundant.replace(function);
    }
}

impl<I: Instants, const N: usize> Instants for [I; N] {
    fn replace(&mut self, function: &mut dyn FnMut(Instant) -> Instant) {
        self.iter_mut().for_each(|instants| instants.replace(function));
    }
}
