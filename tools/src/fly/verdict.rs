//! Verdict on a flight, with the reasons why it did not pass.

use serde::Serialize;

use super::checks::checks;
use super::flight::{Flight, Interruption};

/// Result of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// All checks held.
    Passed,
    /// At least one check failed.
    Failed,
    /// It was stopped before its planned end.
    Interrupted,
}

/// Outcome and reasons, as `summary.json` has them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// Result of the flight.
    #[serde(rename = "verdict")]
    pub outcome: Outcome,
    /// Reasons why it did not pass, one sentence each; empty if it passed.
    pub reasons: Vec<String>,
}

impl Verdict {
    /// Judges a flight by its [`checks`]. For an interrupted one only failures count that an early end does not
    /// explain.
    pub fn of(flight: &Flight) -> Verdict {
        let faults = faults(flight);
        if let Some(interruption) = flight.interrupted {
            let reasons = [vec![stopped(flight, interruption)], faults].concat();
            return Verdict { outcome: Outcome::Interrupted, reasons };
        }
        let outcome = if faults.is_empty() { Outcome::Passed } else { Outcome::Failed };
        Verdict { outcome, reasons: faults }
    }
}

/// Returns the reasons why checks of a flight failed; empty if all held.
pub fn faults(flight: &Flight) -> Vec<String> {
    checks(flight).into_iter().flat_map(|check| check.reasons).collect()
}

fn stopped(flight: &Flight, interruption: Interruption) -> String {
    let cause = match interruption {
        Interruption::Asked => "Ctrl-C or SIGTERM",
        Interruption::Unread => "its output could not be written any more",
    };
    format!("stopped after {:.3} s of {} s: {cause}", flight.end.as_secs_f64(), flight.plan.end.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use can_twin::wire::frame::WireId;
    use can_twin::wire::time::Time;

    use super::*;
    use crate::fly::fault::{Cause, Fault};
    use crate::fly::observer::Observer;
    use crate::fly::record::{Bus, FlightEvent, Level, Occurrence, SECOND_MASTER};
    use crate::fly::sample;
    use crate::images::support::counters::Counters;

    /// Observes a flight once more, up to this millisecond.
    fn observe(flight: &mut Flight, until_ms: u64) {
        flight.observer = Observer::new(&flight.plan);
        for record in flight.records.iter().filter(|record| record.at < Time::from_ms(until_ms)) {
            flight.observer.on(record);
        }
    }

    #[test]
    fn a_flight_passes_without_a_fault_and_fails_with_one() {
        let mut flight = sample::flight();
        let verdict = |outcome, reasons| Verdict { outcome, reasons };
        assert_eq!(Verdict::of(&flight), verdict(Outcome::Passed, vec![]));
        flight.boards[0].lockups = 1;
        assert_eq!(Verdict::of(&flight), verdict(Outcome::Failed, vec!["master locked up".into()]));
    }

    #[test]
    fn only_resets_that_nobody_commanded_are_faults() {
        let mut flight = sample::flight();
        flight.boards[1].resets = 1;
        assert_eq!(faults(&flight), ["node 2 reset itself 1 times, 0 of them commanded"]);
        flight.observer.on(&sample::frame(40_000, Bus::Nominal, 1, 0x000, &[0x81, 2], &[2]));
        assert!(!faults(&flight).iter().any(|fault| fault.contains("reset itself")), "{:?}", faults(&flight));
    }

    /// Given a minimal slave that stays on the bus that the master has left, then the flight fails, although the slave
    /// is operational there.
    #[test]
    fn a_minimal_slave_on_the_wrong_bus_is_a_fault() {
        let mut flight = sample::flight();
        flight.plan.boards[2].is_minimal = true;
        observe(&mut flight, 22_000);
        let faults = faults(&flight);
        let expected = "node 4 is operational on the nominal bus at the end (selective";
        assert!(faults[0].starts_with(expected), "{faults:?}");
    }

    /// Given an image of the user's whose heartbeats stop at 30 s of 40 s, then the flight fails and names it, no slave but the other one
    /// counts as operational, and the longest gap reaches to the end.
    #[test]
    fn flight_of_a_dead_user_slave_fails() {
        let mut flight = sample::flight();
        flight.plan.boards[1].own_image = Some("own".into());
        let is_beat = |record: &Occurrence| matches!(&record.what, FlightEvent::Frame(seen) if seen.frame.id == WireId::Standard(0x702));
        flight.records.retain(|record| record.at <= Time::from_ms(30_000) || !is_beat(record));
        observe(&mut flight, 50_000);
        flight.observer.conclude(flight.end);
        let reason = "node 2 is silent on the redundant bus at the end";
        let Verdict { outcome, reasons } = Verdict::of(&flight);
        assert_eq!((outcome, &*reasons), (Outcome::Failed, &[reason.to_owned()][..]));
        flight.records.extend([
            sample::log(40_000, 2, Level::Error, "first"),
            sample::log(40_000, 2, Level::Error, "last"),
            sample::log(40_000, 2, Level::Warn, "mild"),
            sample::log(40_000, 4, Level::Error, "other"),
        ]);
        assert_eq!(Verdict::of(&flight).reasons, [format!("{reason}; its log: last")]);
        assert_eq!(sample::summary(&flight).slaves_operational_at_end, 1);
        let gap = flight.heartbeats(2).longest_gap.unwrap();
        assert!(gap > Time::from_ms(9_700), "{} us", gap.as_us());
    }

    #[test]
    fn a_lost_master_without_another_one_is_a_fault() {
        let mut flight = sample::flight();
        flight.plan.faults.push(Fault::new(flight.plan.end, Cause::LoseActive));
        assert_eq!(faults(&flight), ["no master was active at 40 s to lose its power"]);
        flight.records.push(sample::at(40_000, FlightEvent::PowerOff(1)));
        assert_eq!(faults(&flight), ["no board took over from master until the end"]);
        flight.plan.faults.push(Fault::new(Time::from_ms(500), Cause::ResetStandby));
        let expected = "no master was active at 0.5 s, so no standby was reset: give a later --cut-at";
        assert_eq!(faults(&flight)[0], expected);
    }

    /// Given a second board that sends 701h while the active master has power, then the flight fails and names both.
    #[test]
    fn flight_with_two_active_masters_fails() {
        let mut flight = sample::standby::flight();
        assert_eq!(faults(&flight), Vec::<String>::new());
        let rival = sample::frame(11_500, Bus::Redundant, SECOND_MASTER, 0x701, &[5], &[]);
        sample::insert(&mut flight, rival);
        observe(&mut flight, 50_000);
        let expected = "two masters were active: master 2 sent 701h at 11.5 s, while master had power";
        assert_eq!(faults(&flight)[0], expected);
    }

    /// Commands of a user's images are not judged, as the demo does not know how many were due.
    #[test]
    fn commands_of_unknown_images_are_not_judged() {
        let mut flight = sample::flight();
        flight.boards[1].counters = None;
        assert_eq!(Verdict::of(&flight).outcome, Outcome::Failed);
        flight.plan.boards[0].own_image = Some("own".into());
        assert_eq!(Verdict::of(&flight).outcome, Outcome::Passed);
    }

    /// Given a board whose transceiver is at other pins than its image has the controller, then the flight fails, although all slaves are
    /// operational.
    #[test]
    fn a_contradiction_between_image_and_board_is_a_fault() {
        let mut flight = sample::flight();
        let warnings = ["CAN1 takes part in no bus: other pins", "odd bit rate"];
        flight.boards[1].warnings = warnings.map(str::to_owned).into();
        assert_eq!(faults(&flight), ["node 2: CAN1 takes part in no bus: other pins (its log has 1 more)"]);
    }

    /// Given a flight stopped before its slaves were operational, Then only the stop and real damage are reasons.
    #[test]
    fn an_early_end_excuses_slaves_but_no_damage() {
        let mut flight = sample::flight();
        flight.interrupted = Some(Interruption::Asked);
        observe(&mut flight, 0);
        flight.boards.iter_mut().for_each(|board| board.counters = Some(Counters::default()));
        flight.boards[1].panics = 1;
        let Verdict { outcome, reasons } = Verdict::of(&flight);
        assert_eq!(outcome, Outcome::Interrupted);
        let [stopped, damage] = &reasons[..] else { panic!("{reasons:?}") };
        assert!(stopped.starts_with("stopped after ") && stopped.ends_with("Ctrl-C or SIGTERM"), "{stopped}");
        assert_eq!(damage, "node 2 panicked");
    }
}
