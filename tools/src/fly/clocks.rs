//! Compares the slaves' clocks with the master's by the edges of their pulses at the seconds of the spacecraft time.
//!
//! The reference is the twin, which records when each edge appears at its pin. A slave is compared from the first
//! spacecraft time that reaches it, as its clock is not set before. A reset of the slave or of a master sets a clock
//! back: then it is compared from the first spacecraft time after the last reset.

use can_twin::pulses::Errors;
use can_twin::spacecraft::{BoardId, Spacecraft};
use can_twin::wire::time::Time;

use super::meaning::{Meaning, NmtState};
use super::observer::Observer;
use super::phase::Phase;
use super::record::{MASTER, Node, Occurrence, SECOND_MASTER, Seen, frames, is_master};
use super::unjudged::{SETTLING, Unjudged};

/// Period of the pulses of the shipped images.
const PERIOD: Time = Time::from_ms(1000);

/// The clock of a slave against that of the master.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// Slave of the clock.
    pub node: Node,
    /// First spacecraft time that it received as operational.
    pub set: Time,
    /// Errors of each second from then on.
    pub errors: Errors,
}

impl Clock {
    /// Compares the instants of pulses, ns and ascending.
    fn between(node: Node, set: Time, master: &[f64], slave: &[f64]) -> Clock {
        let since = |pulses: &[f64]| {
            let first = pulses.partition_point(|pulse| pulse * 1e-9 < set.as_secs_f64());
            pulses[first..].to_vec()
        };
        Clock { node, set, errors: Errors::between(&since(master), &since(slave), PERIOD) }
    }

    /// Returns the settled part; `None` if the flight was too short for it.
    pub fn settled(&self) -> Option<Errors> {
        let settled = self.errors.within(self.set + SETTLING, Time(u64::MAX));
        (!settled.samples.is_empty()).then_some(settled)
    }
}

/// Collects pulses during the flight.
#[derive(Debug, Default)]
pub struct ClockWatch {
    /// Rising edges of each board, ns; `None` for a board without a pin for them.
    pulses: Vec<Option<Vec<f64>>>,
}

impl ClockWatch {
    /// Takes the new edges of all boards.
    pub fn look(&mut self, spacecraft: &mut Spacecraft) {
        self.pulses.resize(spacecraft.boards().count(), None);
        for (board, pulses) in self.pulses.iter_mut().enumerate() {
            let board = spacecraft.board_mut(BoardId(board));
            let (pulse, edges) = (board.config().model.pins.pulse, board.take_edges());
            let Some(pulse) = pulse else { continue };
            let edges = edges.into_iter().filter(|edge| edge.pin == pulse && edge.high);
            pulses.get_or_insert_default().extend(edges.map(|edge| edge.ns()));
        }
    }

    /// Returns the clock of each slave, or the cause for which it cannot be compared; `nodes` are those of the boards.
    pub fn clocks(
        &self,
        nodes: &[Node],
        observer: &Observer,
        records: &[Occurrence],
    ) -> Vec<(Node, Result<Clock, Unjudged>)> {
        let slaves = nodes.iter().filter(|node| !is_master(**node));
        slaves.map(|&node| (node, self.clock(node, nodes, observer, records))).collect()
    }

    fn clock(
        &self,
        node: Node,
        nodes: &[Node],
        observer: &Observer,
        records: &[Occurrence],
    ) -> Result<Clock, Unjudged> {
        let resets = [MASTER, SECOND_MASTER, node].map(|board| last_reset(board, records));
        let set = first_time(node, resets.into_iter().fold(Time::ZERO, Time::max), observer, records)?;
        let pulses = |board| {
            let pulses =
                nodes.iter().zip(&self.pulses).find(|(of, _)| **of == board).map(|(_, pulses)| pulses);
            pulses.and_then(Option::as_deref)
        };
        let (Some(master), Some(slave)) = (pulses(MASTER), pulses(node)) else {
            return Err(Unjudged::NoPin { board: if pulses(node).is_none() { node } else { MASTER } });
        };
        let master = followed(master, pulses(SECOND_MASTER).unwrap_or_default());
        let clock = Clock::between(node, set, &master, slave);
        let is_silent = |pulses: &[f64]| pulses.last().is_none_or(|last| last * 1e-9 < set.as_secs_f64());
        match () {
            () if !clock.errors.samples.is_empty() => Ok(clock),
            () if is_silent(&master) => Err(Unjudged::NoPulse { board: MASTER, set }),
            () if is_silent(slave) => Err(Unjudged::NoPulse { board: node, set }),
            () => Err(Unjudged::NoPair { set }),
        }
    }
}

/// Returns the pulses of one master, then those of the other one that took over. The board that lost its power ends
/// first.
fn followed(master: &[f64], second: &[f64]) -> Vec<f64> {
    let ends_first = |pulses: &[f64], others: &[f64]| pulses.last() < others.last();
    let (lost, other) = if ends_first(master, second) { (master, second) } else { (second, master) };
    if lost.is_empty() || second.is_empty() {
        return master.to_vec();
    }
    // Plus half a period, so that a pulse of the same second is not counted twice.
    let end = lost.last().copied().unwrap_or(f64::MIN) + PERIOD.as_secs_f64() * 5e8;
    lost.iter().chain(other.iter().filter(|pulse| **pulse > end)).copied().collect()
}

/// Returns the last boot-up message of a board, except its first one; time zero if there is none.
fn last_reset(board: Node, records: &[Occurrence]) -> Time {
    let is_own =
        |seen: &Seen| matches!(seen.meaning, Some(Meaning::BootUp { node }) if seen.board(node) == board);
    let boot_ups = frames(records).filter(|(_, seen)| is_own(seen));
    boot_ups.skip(1).last().map_or(Time::ZERO, |(at, _)| at)
}

/// Returns when an operational slave first received the spacecraft time, from `since` on.
fn first_time(
    node: Node,
    since: Time,
    observer: &Observer,
    records: &[Occurrence],
) -> Result<Time, Unjudged> {
    let is_operational = |at: Time| {
        let mut spans = observer.nodes.get(&node).into_iter().flat_map(|track| track.spans.iter().rev());
        let span = spans.find(|span| span.from < at);
        span.is_some_and(|span| span.phase == Phase::Nmt(NmtState::Operational))
    };
    let is_time = |seen: &Seen| matches!(seen.meaning, Some(Meaning::SpacecraftTime(_)));
    let mut cause = Unjudged::NotSent { since };
    for (at, seen) in frames(records).filter(|(at, seen)| *at >= since && is_time(seen)) {
        let is_received = seen.reached.contains(node);
        cause = match cause {
            _ if is_received && is_operational(at) => return Ok(at),
            _ if is_received => Unjudged::NotOperational { since },
            Unjudged::NotSent { .. } => Unjudged::NotReceived { since },
            cause => cause,
        };
    }
    Err(cause)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    /// Given a slave whose pulses are arbitrary until its clock is set at 2.5 s, Then they count from the master's
    /// pulse at 3 s on.
    #[test]
    fn pulses_count_from_the_first_time_received() {
        let master = [1e9, 2e9, 3e9, 4e9, 5e9];
        let slave = [1.2e9, 2.2e9, 3e9 + 70.0, 4e9 - 30.0, 5e9 + 10.0];
        let clock = Clock::between(2, Time::from_ms(2500), &master, &slave);
        let samples: Vec<(f64, f64)> =
            clock.errors.samples.iter().map(|sample| (sample.at.round(), sample.error_ns)).collect();
        assert_eq!(samples, [(3.0, 70.0), (4.0, -30.0), (5.0, 10.0)]);
        assert_eq!(clock.errors.unpaired, 0);
    }

    #[test]
    fn a_missing_pulse_is_no_error() {
        let clock = Clock::between(2, Time::ZERO, &[1e9, 2e9, 3e9], &[1e9 + 5.0, 3e9 + 6.0]);
        assert_eq!((clock.errors.samples.len(), clock.errors.worst_ns()), (2, 6.0));
        assert_eq!(clock.errors.unpaired, 1);
    }

    /// Set at 0.5 s, it is settled from 20.5 s on: the pulses of 21 s and 22 s are 3 ns and 4 ns off.
    #[test]
    fn settled_is_what_comes_20_s_after_the_first_time() {
        let master: Vec<f64> = (1..23).map(|second| f64::from(second) * 1e9).collect();
        let mut slave: Vec<f64> = master.iter().map(|pulse| pulse + 1000.0).collect();
        (slave[20], slave[21]) = (21e9 + 3.0, 22e9 - 4.0);
        let settled = Clock::between(2, Time::from_ms(500), &master, &slave).settled().unwrap();
        assert_eq!((settled.samples.len(), settled.worst_ns()), (2, 4.0));
        assert!((settled.rms_ns() - 12.5_f64.sqrt()).abs() < 1e-9);
        assert_eq!(Clock::between(2, Time::from_ms(500), &master[..20], &slave[..20]).settled(), None);
    }

    /// The master sends its time every 10 s from 50 ms on; slaves are operational since 240 ms.
    #[test]
    fn a_time_that_a_slave_was_not_ready_for_sets_no_clock() {
        let flight = sample::flight();
        let first = |begin| first_time(2, begin, &flight.observer, &flight.records);
        assert_eq!(first(Time::ZERO), Ok(Time::from_ms(10_050)));
        let second = first(Time::from_ms(12_000));
        assert_eq!(second, Ok(Time::from_ms(20_050 + 10_000)), "{:?}", flight.switch());
    }

    /// Given slave 4, which is pre-operational from 22.3 s to 32.3 s and does not hear the redundant bus then, then each cause has its
    /// own result.
    #[test]
    fn time_that_sets_no_clock_has_a_cause() {
        let mut flight = sample::flight();
        let first = |flight: &crate::fly::flight::Flight, since| {
            first_time(4, Time::from_ms(since), &flight.observer, &flight.records)
        };
        let since = Time::from_ms(30_060);
        assert_eq!(first(&flight, 30_060), Err(Unjudged::NotSent { since }));
        let since = Time::from_ms(30_000);
        assert_eq!(first(&flight, 30_000), Err(Unjudged::NotReceived { since }));
        let since = Time::from_ms(22_500);
        let time = sample::frame(25_000, crate::fly::record::Bus::Nominal, 1, 0x181, &[0; 7], &[4]);
        sample::insert(&mut flight, time);
        assert_eq!(first(&flight, 22_500), Err(Unjudged::NotOperational { since }));
    }

    /// Given slave 2, whose clock is set at 10.05 s, then its pulses or their absence decide the result.
    #[test]
    fn clock_without_pulses_has_a_cause() {
        let flight = sample::flight();
        let set = Time::from_ms(10_050);
        let pulses = |second: f64| Some(vec![second * 1e9]);
        for (master, slave, expected) in [
            (pulses(11.0), pulses(11.1), None),
            (None, pulses(11.0), Some(Unjudged::NoPin { board: MASTER })),
            (pulses(11.0), None, Some(Unjudged::NoPin { board: 2 })),
            (pulses(9.0), pulses(11.0), Some(Unjudged::NoPulse { board: MASTER, set })),
            (pulses(11.0), pulses(9.0), Some(Unjudged::NoPulse { board: 2, set })),
            (pulses(11.0), pulses(12.0), Some(Unjudged::NoPair { set })),
        ] {
            let watch = ClockWatch { pulses: vec![master, slave] };
            let clocks = watch.clocks(&[MASTER, 2], &flight.observer, &flight.records);
            assert_eq!(clocks[0].1.as_ref().err().copied(), expected);
        }
    }

    /// Given a slave that boots a second time, then its clock counts from the first spacecraft time after that.
    #[test]
    fn clock_is_compared_after_the_last_reset() {
        let mut flight = sample::flight();
        assert_eq!(last_reset(2, &flight.records), Time::ZERO);
        let boot_up = sample::frame(15_000, crate::fly::record::Bus::Nominal, 2, 0x702, &[0], &[1]);
        sample::insert(&mut flight, boot_up);
        assert_eq!(last_reset(2, &flight.records), Time::from_ms(15_000));
        assert_eq!(last_reset(4, &flight.records), Time::ZERO);
    }
}
