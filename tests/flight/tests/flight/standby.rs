//! Two master boards: one is active, the other one is silent and takes over (profile `standby`: consumer time of the standby
//! 400 ms, of slaves 250 ms; a slave changes the bus after 500 ms).

use std::sync::LazyLock;

use can_twin::spacecraft::{BoardId, Bus};
use can_twin::wire::time::Time;
use flight::standby::*;
use flight::*;

/// A flight in which the standby takes over at 3 s, when prime loses its power between two heartbeats.
static TAKEOVER: LazyLock<Recording> = LazyLock::new(|| {
    let mut flight = flight(&ALL);
    flight.fly_to(3_000);
    flight.twin.power(BoardId(0), false);
    flight.fly_to(5_000);
    flight.seen
});

/// Verifies: ECSS 8.1a
#[test]
fn of_two_boards_powered_together_prime_is_active_other_silent() {
    let first = heartbeats(&TAKEOVER, BoardId(0))[0].1;
    assert!(about(ms(720), ms(30)).contains(&first), "{} us", first.as_us());
    assert!(heartbeats(&TAKEOVER, BoardId(1)).iter().all(|(start, ..)| *start > ms(3_000)));
    assert!(!TAKEOVER.of(SECOND).any(|seen| seen.end < ms(3_000)), "no frame");
    let mut attempts = Bus::ALL.into_iter().flat_map(|bus| TAKEOVER.attempts(SECOND, bus));
    assert!(!attempts.any(|at| at < ms(3_000)), "nor an attempt");
    TAKEOVER.assert_said(SECOND, "Standby (MasterHeard)", Time::ZERO);
}

/// Given a standby, when the active master loses its power, then the standby is active within its consumer time and 10 ms. Slaves,
/// which are Pre-operational on their bus by then, are started at once, and commands flow.
///
/// Verifies: ECSS 8.1a, 8.1b, 8.3.3f
#[test]
fn a_standby_takes_over_within_its_consumer_time() {
    let last = heartbeats(&TAKEOVER, BoardId(0)).last().unwrap().1;
    let (start, _, bus) = heartbeats(&TAKEOVER, BoardId(1))[0];
    let taken = start.since(last);
    assert!(taken < ms(410), "{} us", taken.as_us());
    assert_eq!(bus, Bus::Nominal);
    TAKEOVER.assert_operational([2, 3], Bus::Nominal);
    for node in [2_u8, 3] {
        let id = 0x700 + u16::from(node);
        let runs = TAKEOVER.first_after(start, |seen| seen.id() == Some(id) && seen.data() == [OPERATIONAL]);
        let runs = runs.unwrap().end.since(start);
        assert!(runs < ms(15), "{} us", runs.as_us());
        let command = TAKEOVER.first_after(start, |seen| seen.id() == Some(0x300 + u16::from(node)));
        let flows = command.unwrap().end.since(start);
        assert!(flows < ms(1_000), "{} us", flows.as_us());
    }
    let mut nmt = TAKEOVER.with_id(0).filter(|seen| seen.start > ms(3_000));
    assert!(nmt.all(|seen| seen.data()[0] == 1), "start, and no reset");
}

/// Given slaves that were configured, when the standby has taken over, then it reads 1020h of each, and not before.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_new_master_checks_the_configuration_after_the_takeover() {
    let start = heartbeats(&TAKEOVER, BoardId(1))[0].0;
    for node in [2_u8, 3] {
        let stamp = |seen: &&Seen| seen.data()[..3] == [0x40, 0x20, 0x10];
        let sent = || TAKEOVER.sent(SECOND, Bus::Nominal, 0x600 + u16::from(node));
        assert!(
            sent().any(|seen| stamp(&seen)) && sent().filter(stamp).all(|seen| seen.start > start),
            "{node}"
        );
        assert!(!sent().any(|seen| seen.data()[0] & 0xE0 == 0x20), "nothing was wrong");
    }
}

/// Given a standby that has taken over, when the other board gets its power back at 5 s, then that board stays the
/// standby.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_board_that_comes_back_stays_standby() {
    let mut flight = flight(&ALL);
    flight.fly_to(3_000);
    flight.twin.power(BoardId(0), false);
    flight.fly_to(4_000);
    flight.twin.power(BoardId(0), true);
    flight.fly_to(7_000);
    assert!(is_active(&flight, BoardId(1)) && !is_active(&flight, BoardId(0)));
    assert_eq!(flight.driven(PRIME, ms(4_000)), 0);
    flight.assert_operational([2, 3], Bus::Nominal);
    flight.assert_kept_running([2, 3], ms(3_500));
}

/// Verifies: ECSS 8.1a
#[test]
fn a_prime_board_that_is_late_is_the_standby() {
    let mut flight = flight(&[BoardSetup { power_on_ms: 900, ..ALL[0] }, ALL[1], ALL[2], ALL[3]]);
    flight.fly_to(4_000);
    assert!(is_active(&flight, BoardId(1)));
    assert_eq!(flight.driven(PRIME, Time::ZERO), 0);
}

/// Given both buses cut between prime and all other boards, so that the second board takes over, when the cuts are
/// healed, then both boards are active, and prime, which hears no slave, yields within two heartbeat periods.
///
/// Verifies: ECSS 8.1a
#[test]
fn of_two_active_masters_the_one_without_slaves_yields() {
    let mut flight = flight(&ALL);
    flight.fly_to(3_000);
    Bus::ALL.into_iter().for_each(|bus| flight.twin.wire_mut(bus).cut(BETWEEN_MASTERS_M));
    flight.fly_to(6_000);
    assert!(is_active(&flight, BoardId(1)));
    let tries = |bus| flight.attempts(PRIME, bus).any(|at| at > ms(5_800));
    assert!(Bus::ALL.into_iter().any(tries), "active too");
    Bus::ALL.into_iter().for_each(|bus| flight.twin.wire_mut(bus).restore(BETWEEN_MASTERS_M));
    flight.fly_to(6_200);
    flight.assert_said(PRIME, "Standby (Yielded)", ms(6_000));
    assert_eq!(flight.said(SECOND, "Standby", ms(6_000)), None);
    flight.fly_to(7_000);
    assert_eq!(flight.driven(PRIME, ms(6_200)), 0);
    flight.assert_operational([2, 3], Bus::Nominal);
}

/// Given two masters and no slave, when one is active, then the other one acknowledges no frame but receives them. It
/// stays the standby, although unacknowledged SYNCs block the heartbeats. A slave that gets its power at 5 s is started
/// by the board that was active all the time.
///
/// Verifies: ECSS 8.1a
#[test]
fn a_standby_acknowledges_nothing() {
    let mut flight = flight(&[ALL[0], ALL[1], BoardSetup { power_on_ms: 5_000, ..ALL[2] }]);
    flight.fly_to(5_000);
    assert_eq!(flight.frames.len(), 0, "nobody acknowledges");
    assert!(flight.attempts(PRIME, Bus::Nominal).count() > 0);
    flight.assert_said(SECOND, "Standby (MasterHeard)", Time::ZERO);
    flight.fly_to(6_500);
    assert_eq!(flight.driven(SECOND, Time::ZERO), 0, "{}", flight.log(SECOND));
    assert!(is_active(&flight, BoardId(0)) && flight.said(PRIME, "Standby", Time::ZERO).is_none());
    assert!([Bus::Nominal, Bus::Redundant].into_iter().any(|bus| flight.is_operational(2, bus)));
}
