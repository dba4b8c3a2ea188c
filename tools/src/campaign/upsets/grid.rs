//! Instants at which flights stop: the same in each flight, so that copies before an upset are equal to the tick.

use can_twin::wire::time::Time;

/// First instant of an upset, microseconds.
pub const FIRST_US: u64 = 5_000_000;
/// Distance of instants, microseconds. It has no common factor with the periods of the nodes.
pub const STEP_US: u64 = 1_009;
/// Number of instants: the last one is before 6 s.
pub const STEPS: u64 = 991;
/// Distance of stops after the last instant, microseconds.
const SAMPLE_US: u64 = 500_000;

/// Returns an instant by its number, microseconds.
pub const fn at(number: u64) -> u64 {
    FIRST_US + number * STEP_US
}

/// Returns whether an upset may occur at this instant.
pub const fn is_on(us: u64) -> bool {
    us >= FIRST_US && us <= at(STEPS - 1) && (us - FIRST_US).is_multiple_of(STEP_US)
}

/// Returns the next stop of a flight.
pub fn next(now: Time) -> Time {
    let us = now.as_us();
    let sampled = (us / SAMPLE_US + 1) * SAMPLE_US;
    let number = (us + STEP_US).saturating_sub(FIRST_US) / STEP_US;
    let next = if us < FIRST_US { FIRST_US } else { at(number) };
    Time::from_us(if is_on(next) { next } else { sampled })
}

/// Returns whether services are sampled at a stop.
pub const fn is_sample(us: u64) -> bool {
    us.is_multiple_of(SAMPLE_US)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_are_the_instants_and_then_each_half_second() {
        let next = |us| super::next(Time::from_us(us)).as_us();
        assert_eq!((next(5_000_000), next(5_001_009)), (5_001_009, 5_002_018));
        let last = at(STEPS - 1);
        assert_eq!((next(last - 1), next(last), next(6_000_000)), (last, 6_000_000, 6_500_000));
        assert_eq!(next(4_000_000), FIRST_US);
    }
}
