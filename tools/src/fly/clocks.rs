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

/// Period of the pulses of the shipped images.
const PERIOD: Time = Time::from_ms(1000);

/// Time after which a clock counts as settled.
pub const SETTLING: Time = Time::from_ms(20_000);

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
    /// Rising edges of each board, ns.
    pulses: Vec<Vec<f64>>,
}

impl ClockWatch {
    /// Takes the new edges of all boards.
    pub fn look(&mut self, spacecraft: &mut Spacecraft) {
        self.pulses.resize(spacecraft.boards().count(), Vec::new());
        for (board, pulses) in self.pulses.iter_mut().enumerate() {
            let board = spacecraft.board_mut(BoardId(board));
            let pulse = board.config().model.pins.pulse;
            let edges = board.take_edges().into_iter();
            pulses.extend(edges.filter(|edge| Some(edge.pin) == pulse && edge.high).map(|edge| edge.ns()));
        }
    }

    /// Returns the clocks of the slaves that were set; `nodes` are those of the boards.
    pub fn clocks(&self, nodes: &[Node], observer: &Observer, records: &[Occurrence]) -> Vec<Clock> {
        let pulses =
            |node| nodes.iter().zip(&self.pulses).find(|(of, _)| **of == node).map(|(_, pulses)| pulses);
        let Some(master) = pulses(MASTER) else { return Vec::new() };
        let master = &followed(master, pulses(SECOND_MASTER).map_or(&[], Vec::as_slice));
        let slaves = nodes.iter().filter(|node| !is_master(**node));
        slaves
            .filter_map(|&node| {
                let resets = [MASTER, SECOND_MASTER, node].map(|board| last_reset(board, records));
                let begin = resets.into_iter().max()?;
                let set = first_time(node, begin, observer, records)?;
                let clock = Clock::between(node, set, master, pulses(node)?);
                (!clock.errors.samples.is_empty()).then_some(clock)
            })
            .collect()
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

/// Returns when an operational slave first received the spacecraft time, from `begin` on.
fn first_time(node: Node, begin: Time, observer: &Observer, records: &[Occurrence]) -> Option<Time> {
    let spans = &observer.nodes.get(&node)?.spans;
    let is_operational = |at: Time| {
        let span = spans.iter().rev().find(|span| span.from < at);
        span.is_some_and(|span| span.phase == Phase::Nmt(NmtState::Operational))
    };
    let is_time = |seen: &Seen| matches!(seen.meaning, Some(Meaning::SpacecraftTime(_)));
    let received = frames(records).filter(|(_, seen)| is_time(seen) && seen.reached.contains(node));
    received.map(|(at, _)| at).find(|at| *at >= begin && is_operational(*at))
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
        assert_eq!(first(Time::ZERO), Some(Time::from_ms(10_050)));
        let second = first(Time::from_ms(12_000));
        assert_eq!(second, Some(Time::from_ms(20_050 + 10_000)), "{:?}", flight.switch());
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
