//! Checks of a flight: each with its limit, the value of the flight, and whether it held.

mod criteria;

use std::collections::BTreeMap;

use serde::Serialize;

use super::flight::{BoardCount, Flight};
use super::meaning::Scope;
use super::narrator::name;
use super::plan::BusAccess;
use super::record::{Bus, MASTER, Node};
use super::track::Track;
use super::unheard::{Unheard, unheard};

/// One check of the verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// Description of the check.
    pub name: &'static str,
    /// Values that pass.
    pub limit: String,
    /// Value of this flight.
    pub measured: String,
    /// Result of the comparison.
    pub result: CheckResult,
    /// Reasons of a failure, one sentence for each affected board; empty when it held.
    #[serde(skip)]
    pub reasons: Vec<String>,
}

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum CheckResult {
    /// The value is within the limit.
    #[serde(rename = "held")]
    Held,
    /// The value is outside the limit.
    #[serde(rename = "failed")]
    Failed,
    /// The flight was interrupted before it could be judged.
    #[serde(rename = "not judged")]
    NotJudged,
}

impl CheckResult {
    /// Returns the name in texts and in `summary.json`.
    pub fn name(self) -> &'static str {
        match self {
            CheckResult::Held => "held",
            CheckResult::Failed => "failed",
            CheckResult::NotJudged => "not judged",
        }
    }
}

impl Check {
    fn new(
        name: &'static str,
        limit: impl ToString,
        measured: impl ToString,
        reasons: impl IntoIterator<Item = String>,
    ) -> Check {
        let reasons: Vec<String> = reasons.into_iter().collect();
        let result = if reasons.is_empty() { CheckResult::Held } else { CheckResult::Failed };
        Check { name, limit: limit.to_string(), measured: measured.to_string(), result, reasons }
    }

    /// Makes a check of a count over all boards that must be zero. `reason` gives the sentence for a board with a
    /// count.
    fn none(
        name: &'static str,
        flight: &Flight,
        count: impl Fn(&BoardCount) -> u64,
        reason: impl Fn(&BoardCount, u64) -> String,
    ) -> Check {
        let counts =
            || flight.boards.iter().map(|board| (board, count(board))).filter(|(_, count)| *count > 0);
        let sum: u64 = counts().map(|(_, count)| count).sum();
        Check::new(name, 0, sum, counts().map(|(board, count)| reason(board, count)))
    }
}

/// Returns all checks of a flight. An interrupted flight is not judged by its end or by faults that it did not reach.
pub fn checks(flight: &Flight) -> Vec<Check> {
    let mut of_the_end = vec![operational(flight), errors(flight)];
    of_the_end.extend(of_masters(flight));
    of_the_end.extend(criteria::faults(flight));
    of_the_end.extend(criteria::criteria(flight));
    if flight.interrupted.is_some() {
        for check in &mut of_the_end {
            check.result = CheckResult::NotJudged;
            check.reasons.clear();
        }
    }
    // First, because it may explain the others.
    [vec![bit_rates(flight)], of_the_end, damage(flight)].concat()
}

/// Checks the bit rates of each bus: boards with different rates destroy each other's frames.
fn bit_rates(flight: &Flight) -> Check {
    let of = |bus: Bus| {
        let mut rates: BTreeMap<u32, Vec<String>> = BTreeMap::new();
        for board in &flight.boards {
            if let Some(rate) = board.bit_rates[bus as usize] {
                rates.entry(rate).or_default().push(name(board.node));
            }
        }
        (bus, rates)
    };
    let buses = Bus::ALL.map(of);
    let most = buses.iter().map(|(_, rates)| rates.len()).max();
    let reasons = buses.iter().filter(|(_, rates)| rates.len() > 1).map(|(bus, rates)| {
        let boards = rates.iter().map(|(rate, boards)| format!("{} at {rate} kbit/s", boards.join(", ")));
        let boards: Vec<String> = boards.collect();
        format!("the bit rates on the {} bus differ: {}", bus.name(), boards.join("; "))
    });
    Check::new("bit rates on a bus", "1 at most", most.unwrap_or(0), reasons)
}

/// Checks that the slaves are operational at the end on the bus of the master; minimal ones on any bus.
fn operational(flight: &Flight) -> Check {
    let master = flight.observer.active_master().unwrap_or(MASTER);
    let bus = flight.observer.nodes[&master].now().bus;
    let is_operational = |track: &Track| match track.operational_on() {
        Some(at) => !track.is_minimal || at == bus,
        None => false,
    };
    // A slave whose power a fault took away is not there at the end.
    let is_judged = |node: Node, track: &Track| {
        let is_off = !track.now().phase.is_powered() && flight.plan.restarts(node);
        !is_off && !criteria::may_be_lost(flight, node)
    };
    let judged = || flight.observer.slaves().filter(|(node, track)| is_judged(*node, track));
    let slaves = judged().count();
    let others: Vec<(Node, &Track)> = judged().filter(|(_, track)| !is_operational(track)).collect();
    Check::new(
        "slaves operational at the end",
        format_args!("{slaves} of {slaves}"),
        format_args!("{} of {slaves}", slaves - others.len()),
        others.iter().map(|(node, track)| not_operational(flight, *node, track)),
    )
}

fn not_operational(flight: &Flight, node: Node, track: &Track) -> String {
    let now = track.now();
    let mut fault =
        format!("{} is {} on the {} bus at the end", name(node), now.phase.name(), now.bus.name());
    if let (Some(BusAccess::Selective), Some((cut, _))) = (track.access, flight.cut()) {
        fault += &format!(
            " (selective access: it searches {} s after the master's last heartbeat, the run ended \
             {:.1} s after the cut)",
            flight.plan.toggling_time().as_secs_f64(),
            flight.end.since(cut).as_secs_f64()
        );
    }
    if let Some(error) = flight.last_error(node) {
        fault += &format!("; its log: {error}");
    }
    fault
}

/// Checks for active errors that a board reported and the master did not receive.
fn errors(flight: &Flight) -> Check {
    let unheard = unheard(flight);
    let reasons = unheard.iter().map(|Unheard { node, code, source, at }| {
        format!(
            "{} reported error {code:04X}h (source {source}) at {:.3} s, and the master never heard it",
            name(*node),
            at.as_secs_f64()
        )
    });
    Check::new("active errors that the master does not know", 0, unheard.len(), reasons)
}

/// Returns the checks of two master boards: one is active at a time, and one was active at each fault of the demo.
fn of_masters(flight: &Flight) -> Vec<Check> {
    let rivalry = flight.observer.rivalry().map(|rival| {
        let (at, rival, active) = (rival.first.as_secs_f64(), name(rival.to), name(rival.from));
        format!("two masters were active: {rival} sent 701h at {at} s, while {active} had power")
    });
    let mut checks = Vec::new();
    if flight.masters() > 1 || rivalry.is_some() {
        let measured = if rivalry.is_some() { 2 } else { 1 };
        checks.push(Check::new("masters active at the same time", "1 at most", measured, rivalry));
    }
    if let Some(at) = flight.plan.standby_reset() {
        let missing = flight.standby_reset().is_none().then(|| {
            let at = at.as_secs_f64();
            format!("no master was active at {at} s, so no standby was reset: give a later --cut-at")
        });
        let measured = flight.standby_reset().map_or("none".into(), |(_, board)| name(board));
        checks.push(Check::new("standby to be reset", "one board", measured, missing));
    }
    if let Some(at) = flight.plan.loss() {
        let reason = match (flight.loss(), flight.takeover()) {
            (None, _) => Some(format!("no master was active at {} s to lose its power", at.as_secs_f64())),
            (Some((_, board)), None) => {
                Some(format!("no board took over from {} until the end", name(board)))
            }
            (Some(_), Some(_)) => None,
        };
        let measured = flight.takeover().map_or("none".into(), |takeover| name(takeover.to));
        checks.push(Check::new("takeover after the loss of the master", "another board", measured, reason));
    }
    checks
}

/// Returns the checks that also apply to an interrupted flight.
fn damage(flight: &Flight) -> Vec<Check> {
    let stops = Check::none(
        "boards that the twin had to stop",
        flight,
        |board| u64::from(board.stopped.is_some()),
        |board, _| format!("the twin stopped {}", board.stopped.as_deref().unwrap_or_default()),
    );
    let warnings = Check::none(
        "contradictions between an image and its board",
        flight,
        |board| board.warnings.len() as u64,
        |board, count| {
            let first = board.warnings.first().map_or("", |warning| warning);
            let others = if count > 1 { format!(" (its log has {} more)", count - 1) } else { String::new() };
            format!("{}: {first}{others}", name(board.node))
        },
    );
    let counted = |title, count: fn(&BoardCount) -> u64, words: fn(u64) -> String| {
        let reason = |board: &BoardCount, count| format!("{} {}", name(board.node), words(count));
        Check::none(title, flight, count, reason)
    };
    let lockups = counted("lock-ups of a CPU", |board| board.lockups, |_| "locked up".into());
    let panics = counted("panics of a firmware", |board| board.panics, |_| "panicked".into());
    let lost = counted("frames lost", |board| board.lost_frames, |lost| format!("lost {lost} frames"));
    let due = |board: &BoardCount| flight.observer.nodes.get(&board.node).map(|track| track.resets_due);
    let resets = Check::none(
        "resets without a command",
        flight,
        |board| due(board).map_or(0, |due| board.resets.saturating_sub(due)),
        |board, _| {
            let due = due(board).unwrap_or_default();
            format!("{} reset itself {} times, {due} of them commanded", name(board.node), board.resets)
        },
    );
    let commands = (flight.plan.scope() == Scope::Mission).then(|| commands(flight));
    [stops, warnings, lockups, panics, resets].into_iter().chain(commands).chain([lost]).collect()
}

/// Checks the commands executed by each slave against the due ones.
fn commands(flight: &Flight) -> Check {
    let of = |board: &BoardCount| {
        let track = flight.observer.nodes.get(&board.node).filter(|track| track.access.is_some())?;
        // The counters of a board that starts again begin at zero.
        if flight.plan.restarts(board.node) {
            return None;
        }
        let executed = board.counters.map_or(0, |counters| u64::from(counters.commands));
        Some((board.node, executed, track.tc_due))
    };
    let counts = || flight.boards.iter().filter_map(of);
    let wrong = counts().filter(|(_, executed, due)| executed != due);
    Check::new(
        "commands executed by the slaves, each one as many as were due",
        counts().map(|(.., due)| due).sum::<u64>(),
        counts().map(|(_, executed, _)| executed).sum::<u64>(),
        wrong.map(|(node, executed, due)| {
            format!("{} executed {executed} commands, {due} were due", name(node))
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::flight::Interruption;
    use crate::fly::sample;

    /// Checks the row of the check whose name begins so.
    fn assert_row(flight: &Flight, name: &str, limit: &str, measured: &str, result: CheckResult) {
        let check = checks(flight).into_iter().find(|check| check.name.starts_with(name)).expect(name);
        assert_eq!((&*check.limit, &*check.measured, check.result), (limit, measured, result), "{name}");
    }

    #[test]
    fn every_check_has_its_limit_and_its_value() {
        let mut flight = sample::flight();
        flight.boards[2].lost_frames = 3;
        assert_row(&flight, "slaves", "2 of 2", "2 of 2", CheckResult::Held);
        assert_row(&flight, "frames lost", "0", "3", CheckResult::Failed);
        let due = sample::COMMANDS_DUE.to_string();
        assert_row(&flight, "commands", &due, &due, CheckResult::Held);
        assert!(!checks(&flight).iter().any(|check| check.name.contains("takeover")));
    }

    #[test]
    fn two_masters_have_checks_of_their_own() {
        let flight = sample::standby::flight();
        assert_row(&flight, "masters active", "1 at most", "1", CheckResult::Held);
        assert_row(&flight, "standby", "one board", "master 2", CheckResult::Held);
        assert_row(&flight, "takeover", "another board", "master 2", CheckResult::Held);
    }

    /// Given slaves that execute too many and too few commands, then the check fails although the sums are equal.
    #[test]
    fn commands_are_compared_slave_by_slave() {
        let mut flight = sample::flight();
        flight.boards[1].counters.as_mut().unwrap().commands += 1;
        flight.boards[2].counters.as_mut().unwrap().commands -= 1;
        let due = sample::COMMANDS_DUE.to_string();
        assert_row(&flight, "commands", &due, &due, CheckResult::Failed);
    }

    /// Given a master for 1 Mbit/s and a slave for 250 kbit/s, then the first reason names both, and the load is 100 % at most.
    #[test]
    fn different_bit_rates_fail_the_flight_first() {
        let mut flight = sample::flight();
        assert_row(&flight, "bit rates", "1 at most", "0", CheckResult::Held);
        for board in &mut flight.boards {
            board.bit_rates = [Some(1000), Some(500)];
        }
        assert_row(&flight, "bit rates", "1 at most", "1", CheckResult::Held);
        flight.boards[2].bit_rates = [Some(250), None];
        flight.boards[2].panics = 1;
        flight.busy = [flight.end + flight.end, flight.end];
        assert_row(&flight, "bit rates", "1 at most", "2", CheckResult::Failed);
        let reasons: Vec<String> = checks(&flight).into_iter().flat_map(|check| check.reasons).collect();
        let first =
            "the bit rates on the nominal bus differ: node 4 at 250 kbit/s; master, node 2 at 1000 kbit/s";
        assert_eq!(reasons, [first, "node 4 panicked"]);
        assert_eq!(Bus::ALL.map(|bus| flight.load(bus)), [1.0, 1.0]);
    }

    #[test]
    fn an_interrupted_flight_is_not_judged_by_its_end() {
        let mut flight = sample::flight();
        flight.interrupted = Some(Interruption::Asked);
        assert_row(&flight, "slaves", "2 of 2", "2 of 2", CheckResult::NotJudged);
        assert_row(&flight, "frames lost", "0", "0", CheckResult::Held);
    }
}
