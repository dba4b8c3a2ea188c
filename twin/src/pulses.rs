//! Compares the clocks of boards by the pulses that they output at the same times of their clocks.
//!
//! Every board raises a pin at the multiples of a period of its spacecraft time. Clocks are set at different instants,
//! so pulses cannot be paired by number. If clocks agree to less than half a period, the nearest pulses belong
//! together.

use crate::board::{AccessError, EmulatedBoard};
use crate::pin::Pin;
use crate::spacecraft::{BoardId, Spacecraft, WireRecord};
use crate::traffic::Traffic;
use crate::wire::time::{TICKS_PER_US, Time};

/// Logs and edges are collected this often.
const SLICE: Time = Time::from_ms(20);

/// Difference of a board's pulse from that of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Instant of the reference's pulse, in seconds since the start of the simulation.
    pub at: f64,
    /// Delay of the board's pulse after it, in ns.
    pub error_ns: f64,
}

/// Differences of a board's clock from that of the reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// Samples in chronological order.
    pub samples: Vec<Sample>,
    /// Pulses of either board without partner: none, or more than one, within half a period.
    pub unpaired: u64,
}

impl Errors {
    /// Pairs the instants of pulses, ns and ascending, of a reference and of a board.
    pub fn between(reference: &[f64], board: &[f64], period: Time) -> Errors {
        let half = nanoseconds(period) / 2.0;
        let mut errors = Errors::default();
        let mut left = board;
        for &at in reference {
            let early = left.partition_point(|&pulse| pulse < at - half);
            errors.unpaired += early as u64;
            left = &left[early..];
            let near = left.partition_point(|&pulse| pulse < at + half);
            match left[..near] {
                [pulse] => errors.samples.push(Sample { at: at * 1e-9, error_ns: pulse - at }),
                _ => errors.unpaired += 1 + near as u64,
            }
            left = &left[near..];
        }
        errors.unpaired += left.len() as u64;
        errors
    }

    /// Joins the errors of several flights.
    pub fn join(flights: impl IntoIterator<Item = Errors>) -> Errors {
        flights.into_iter().fold(Errors::default(), |mut all, errors| {
            all.samples.extend(errors.samples);
            all.unpaired += errors.unpaired;
            all
        })
    }

    /// Returns the samples between two instants, the first included.
    #[must_use]
    pub fn within(&self, from: Time, to: Time) -> Errors {
        let span = from.as_secs_f64()..to.as_secs_f64();
        let samples = self.samples.iter().filter(|sample| span.contains(&sample.at)).copied();
        Errors { samples: samples.collect(), unpaired: self.unpaired }
    }

    /// Root of the mean square, ns.
    pub fn rms_ns(&self) -> f64 {
        let squares: f64 = self.samples.iter().map(|sample| sample.error_ns.powi(2)).sum();
        (squares / self.samples.len().max(1) as f64).sqrt()
    }

    /// Returns the mean, in ns, which shows a constant delay.
    pub fn mean_ns(&self) -> f64 {
        self.samples.iter().map(|sample| sample.error_ns).sum::<f64>() / self.samples.len().max(1) as f64
    }

    /// Returns the smallest distance that a `share` of the samples does not exceed, in ns; zero without samples.
    pub fn quantile_ns(&self, share: f64) -> f64 {
        let mut distances: Vec<f64> = self.samples.iter().map(|sample| sample.error_ns.abs()).collect();
        distances.sort_by(f64::total_cmp);
        let rank = (share * distances.len() as f64).ceil() as usize;
        distances.get(rank.saturating_sub(1)).copied().unwrap_or_default()
    }

    /// The largest distance, ns.
    pub fn worst_ns(&self) -> f64 {
        self.quantile_ns(1.0)
    }
}

/// A flight of boards that make pulses.
#[derive(Debug)]
pub struct Trial {
    spacecraft: Spacecraft,
    traffic: Option<Traffic>,
    pin: Pin,
    /// Rising edges of each board, ns.
    pulses: Vec<Vec<f64>>,
}

impl Trial {
    /// A flight in which boards make their pulses at `pin`.
    pub fn new(spacecraft: Spacecraft, pin: Pin, traffic: Option<Traffic>) -> Trial {
        let pulses = spacecraft.boards().map(|_| Vec::new()).collect();
        Trial { spacecraft, traffic, pin, pulses }
    }

    /// Returns the spacecraft.
    pub fn spacecraft(&mut self) -> &mut Spacecraft {
        &mut self.spacecraft
    }

    /// Runs until `until`. Calls `look` with the spacecraft and the records of its wires fifty times a second.
    ///
    /// # Errors
    /// [`AccessError`] when a program made an access that the model refuses, and errors of `look`.
    pub fn run_until<E: From<AccessError>>(
        &mut self,
        until: Time,
        mut look: impl FnMut(&mut Spacecraft, &[WireRecord]) -> Result<(), E>,
    ) -> Result<(), E> {
        while self.spacecraft.now() < until {
            let next = (self.spacecraft.now() + SLICE).min(until);
            if let Some(traffic) = &mut self.traffic {
                traffic.hand_over(&mut self.spacecraft, next);
            }
            self.spacecraft.run_until(next)?;
            self.spacecraft.take_logs();
            let records = self.spacecraft.take_frames();
            for (board, pulses) in self.pulses.iter_mut().enumerate() {
                pulses.extend(rises(self.spacecraft.board_mut(BoardId(board)), self.pin));
            }
            look(&mut self.spacecraft, &records)?;
        }
        Ok(())
    }

    /// Pulses of a board between two instants, ns.
    pub fn pulses(&self, board: BoardId, from: Time, to: Time) -> &[f64] {
        let pulses = &self.pulses[board.0];
        let place = |time: Time| pulses.partition_point(|&pulse| pulse < nanoseconds(time));
        &pulses[place(from)..place(to)]
    }

    /// Compares the clock of `board` with that of `reference` by the pulses at each `period` between two instants.
    pub fn errors(&self, reference: BoardId, board: BoardId, period: Time, from: Time, to: Time) -> Errors {
        let reference = self.pulses(reference, from, to);
        let (Some(first), Some(last)) = (reference.first(), reference.last()) else {
            return Errors::default();
        };
        let half = nanoseconds(period) / 2.0;
        let near = |pulse: &&f64| (first - half..last + half).contains(*pulse);
        let pulses: Vec<f64> = self.pulses[board.0].iter().filter(near).copied().collect();
        Errors::between(reference, &pulses, period)
    }
}

fn rises(board: &mut EmulatedBoard, pin: Pin) -> impl Iterator<Item = f64> + use<> {
    board.take_edges().into_iter().filter(move |edge| edge.pin == pin && edge.high).map(|edge| edge.ns())
}

fn nanoseconds(time: Time) -> f64 {
    time.0 as f64 * 1000.0 / TICKS_PER_US as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Time = Time::from_ms(10);

    /// Every 10 ms from 1 s on, ns.
    fn pulses(errors: &[f64]) -> Vec<f64> {
        (100..).zip(errors).map(|(n, error)| f64::from(n) * 1e7 + error).collect()
    }

    fn between(board: &[f64]) -> Errors {
        Errors::between(&pulses(&[0.0, 5.0, -5.0, 0.0]), board, PERIOD)
    }

    fn samples(errors: &Errors) -> Vec<f64> {
        errors.samples.iter().map(|sample| sample.error_ns).collect()
    }

    #[test]
    fn pulses_are_paired_with_the_nearest() {
        let errors = between(&pulses(&[40.0, -35.0, 4_000_000.0, 0.0]));
        assert_eq!((samples(&errors), errors.unpaired), (vec![40.0, -40.0, 4_000_005.0, 0.0], 0));
        assert_eq!(errors.samples[1].at, 1.010_000_005);
    }

    #[test]
    fn a_missing_pulse_leaves_its_partner_alone() {
        let mut board = pulses(&[0.0; 4]);
        board.remove(1);
        let errors = between(&board);
        assert_eq!((errors.samples.len(), errors.unpaired), (3, 1));
    }

    #[test]
    fn a_doubled_pulse_is_no_sample() {
        let mut board = pulses(&[0.0; 4]);
        board.insert(2, board[1] + 1000.0);
        let errors = between(&board);
        assert_eq!((errors.samples.len(), errors.unpaired), (3, 3));
    }

    #[test]
    fn pulses_outside_are_counted() {
        let errors = between(&pulses(&[0.0; 6]));
        assert_eq!((errors.samples.len(), errors.unpaired), (4, 2));
        assert_eq!(between(&[]).unpaired, 4);
    }

    /// 1 to 1000, alternating in sign: the root of the mean square is that of (1001 * 2001 / 6).
    #[test]
    fn figures_are_those_of_their_definitions() {
        let sign = |n: u32| if n.is_multiple_of(2) { 1.0 } else { -1.0 };
        let sample = |n: u32| Sample { at: f64::from(n), error_ns: sign(n) * f64::from(n) };
        let errors = Errors { samples: (1..=1000).map(sample).collect(), unpaired: 0 };
        assert!((errors.rms_ns() - 333_833.5_f64.sqrt()).abs() < 1e-9);
        assert_eq!(
            (errors.quantile_ns(0.999), errors.quantile_ns(0.5), errors.worst_ns()),
            (999.0, 500.0, 1000.0)
        );
        assert_eq!(errors.mean_ns(), 0.5);
        let late = errors.within(Time::from_ms(990_000), Time::from_ms(1_000_000));
        assert_eq!((late.samples.len(), late.worst_ns()), (10, 999.0));
        assert_eq!(Errors::default().worst_ns(), 0.0);
    }
}
