//! Checks of the criteria of a mission file, and of its faults.

use can_twin::wire::frame::WireId;
use can_twin::wire::time::Time;

use super::{Check, name};
use crate::fly::criterion::{Criterion, Must};
use crate::fly::flight::Flight;
use crate::fly::meaning::{Meaning, NmtState};
use crate::fly::phase::Phase;
use crate::fly::record::{Node, Seen};

/// First bytes of SDO requests without an answer: abort, and end of a block upload (CiA 301 7.2.4.3).
const UNANSWERED: [u8; 2] = [0x80, 0xA1];

/// Base of the COB-IDs of SDO requests.
const SDO_REQUEST: u16 = 0x600;

/// Checks that all planned faults were caused.
pub fn faults(flight: &Flight) -> Option<Check> {
    let planned = flight.plan.faults.len();
    let reasons = flight.refused.iter().map(|refused| format!("a fault was not caused: {refused}"));
    let caused = planned - flight.refused.len();
    (!flight.refused.is_empty()).then(|| Check::new("faults caused", planned, caused, reasons))
}

/// Checks each criterion.
pub fn criteria(flight: &Flight) -> Vec<Check> {
    flight.plan.criteria.iter().filter_map(|criterion| check(flight, criterion)).collect()
}

/// Returns whether a node may be in any state at the end.
pub fn may_be_lost(flight: &Flight, node: Node) -> bool {
    flight.plan.criteria.iter().any(|criterion| criterion.node == node && criterion.must == Must::MayBeLost)
}

fn check(flight: &Flight, Criterion { node, must, origin }: &Criterion) -> Option<Check> {
    let of = name(*node);
    let (title, limit, measured, held) = match *must {
        Must::MayBeLost => return None,
        Must::OperationalAt(at) => {
            let spans = flight.observer.nodes.get(node).map_or(&[][..], |track| &track.spans);
            let phase = spans.iter().rev().find(|span| span.from <= at).map_or(Phase::Off, |span| span.phase);
            let is_operational = phase == Phase::Nmt(NmtState::Operational);
            let limit = format!("{of} operational at {} s", at.as_secs_f64());
            ("operational in time", limit, phase.name().to_owned(), is_operational)
        }
        Must::FailOverWithin(most) => {
            let took = flight.observer.nodes.get(node).and_then(|track| track.failover);
            let limit = format!("{of}: {} at most", seconds(most));
            (
                "fail-over in time",
                limit,
                took.map_or("none".into(), seconds),
                took.is_some_and(|took| took <= most),
            )
        }
        Must::ClockWithin(most) => {
            let clock = flight.clocks.iter().find(|clock| clock.node == *node);
            let worst = clock.and_then(|clock| clock.settled()).map(|errors| errors.worst_ns() / 1e3);
            let measured = worst.map_or("not judged".into(), |worst| format!("{worst:.3} us"));
            let limit = format!("{of}: {most} us at most");
            ("clock against the master's", limit, measured, worst.is_some_and(|worst| worst <= most))
        }
        Must::AnswerWithin(most) => {
            let slowest = slowest_answer(flight, *node);
            let limit = format!("{of}: {} at most", seconds(most));
            let measured = slowest.map_or("no request".into(), seconds);
            ("answers in time", limit, measured, slowest.is_none_or(|slowest| slowest <= most))
        }
    };
    let reason = (!held).then(|| format!("{origin}: {limit}, found: {measured}"));
    Some(Check::new(title, limit, measured, reason))
}

/// Formats a time, to a microsecond.
fn seconds(time: Time) -> String {
    format!("{} s", (time.as_secs_f64() * 1e6).round() / 1e6)
}

/// Returns the longest time from a request that reached a node to its answer, or to the end of the flight; `None` without a
/// request.
fn slowest_answer(flight: &Flight, node: Node) -> Option<Time> {
    // Of SDO, and of telemetry.
    let mut pending = [None::<Time>; 2];
    let mut slowest = None;
    for (at, seen) in flight.frames() {
        let (kind, is_request) = match seen.meaning {
            Some(Meaning::Sdo { node: of }) if of == node => (0, is_sdo_request(seen)),
            Some(Meaning::TelemetryRequest { node: of, .. }) if of == node => (1, true),
            Some(Meaning::Telemetry { node: of, .. }) if of == node => (1, false),
            _ => continue,
        };
        if !is_request {
            slowest = slowest.max(pending[kind].take().map(|since| at.since(since)));
        } else if seen.reached.contains(node) && expects_answer(seen) {
            pending[kind] = pending[kind].or(Some(at));
        }
    }
    pending
        .into_iter()
        .flatten()
        .map(|since| flight.end.since(since))
        .fold(slowest, |slowest, waited| slowest.max(Some(waited)))
}

fn is_sdo_request(seen: &Seen) -> bool {
    matches!(seen.frame.id, WireId::Standard(id) if id & 0x780 == SDO_REQUEST)
}

fn expects_answer(seen: &Seen) -> bool {
    !is_sdo_request(seen) || !seen.frame.payload().first().is_some_and(|first| UNANSWERED.contains(first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::checks::{CheckResult, checks};
    use crate::fly::record::Bus;
    use crate::fly::sample;

    /// Result of a criterion of node 2 in the sample flight.
    fn judged(must: Must) -> (CheckResult, Vec<String>) {
        let mut flight = sample::flight();
        judge(&mut flight, must)
    }

    fn judge(flight: &mut Flight, must: Must) -> (CheckResult, Vec<String>) {
        flight.plan.criteria = vec![Criterion { node: 2, must, origin: "m.toml:7: criterion[0]".into() }];
        let check = criteria(flight).remove(0);
        (check.result, check.reasons)
    }

    /// Slave 2 is operational from 0.24 s on. Its fail-over takes 605 ms. The error of its clock is 30 or 40 ns after settling.
    /// It answers requests for telemetry within 1 ms, while the master is heard.
    #[test]
    fn each_criterion_has_a_limit_that_the_flight_meets_or_not() {
        let ms = Time::from_ms;
        for (held, failed, found) in [
            (
                Must::OperationalAt(ms(300)),
                Must::OperationalAt(ms(200)),
                "node 2 operational at 0.2 s, found: pre-operational",
            ),
            (Must::FailOverWithin(ms(606)), Must::FailOverWithin(ms(604)), "0.604 s at most, found: 0.605 s"),
            (Must::ClockWithin(0.041), Must::ClockWithin(0.039), "0.039 us at most, found: 0.040 us"),
            (Must::AnswerWithin(ms(1)), Must::AnswerWithin(Time::from_us(900)), "found: 0.001 s"),
        ] {
            assert_eq!(judged(held), (CheckResult::Held, vec![]), "{held:?}");
            let (result, reasons) = judged(failed);
            assert_eq!(result, CheckResult::Failed, "{failed:?}");
            assert!(
                reasons[0].starts_with("m.toml:7: criterion[0]: ") && reasons[0].contains(found),
                "{reasons:?}"
            );
        }
    }

    #[test]
    fn request_without_an_answer_waits_until_the_end() {
        let mut flight = sample::flight();
        flight.records.push(sample::frame(
            39_000,
            Bus::Redundant,
            1,
            0x602,
            &[0x40, 0, 0x10, 0, 0, 0, 0, 0],
            &[2],
        ));
        let (result, reasons) = judge(&mut flight, Must::AnswerWithin(Time::from_ms(500)));
        assert!(result == CheckResult::Failed && reasons[0].ends_with("found: 1 s"), "{reasons:?}");
        // An abort of the client has no answer.
        flight.records.pop();
        flight.records.push(sample::frame(
            39_000,
            Bus::Redundant,
            1,
            0x602,
            &[0x80, 0, 0x10, 0, 0, 0, 0, 0],
            &[2],
        ));
        assert_eq!(judge(&mut flight, Must::AnswerWithin(Time::from_ms(500))).0, CheckResult::Held);
    }

    #[test]
    fn fault_that_was_not_caused_fails_the_flight() {
        let mut flight = sample::flight();
        assert_eq!(faults(&flight), None);
        flight.refused.push("m.toml:9: fault[0]: node 2 has no power".into());
        let reasons: Vec<String> = checks(&flight).into_iter().flat_map(|check| check.reasons).collect();
        assert_eq!(reasons, ["a fault was not caused: m.toml:9: fault[0]: node 2 has no power"]);
    }
}
