//! Faults that hide an active master from its standby. The active one claims with each heartbeat on both buses, so that
//! a standby which hears one bus alone stays silent. Two masters that became active while both buses failed detect each
//! other by their claims.
//!
//! Scripts of the fault campaign, with less time between the faults: node n sits at 2 n metres, the second master behind the last slave.

use can_twin::guest::Presence;
use can_twin::spacecraft::{Bus, LogRecord};
use can_twin::wire::fault::Fault;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::standby::{PRIME, SECOND, flight, is_active, setup};
use flight::*;

const SPACING_M: f64 = 2.0;

/// Makes a spacecraft of two master boards and `slaves` slaves.
fn pair(slaves: u8) -> Flight {
    let last = slaves + 1;
    let place = |nth: u8| SPACING_M * f64::from(nth);
    let of = |node: u8| setup(node, f64::from(node) * 9.0 - 40.0, place(node), 20 + 5 * u64::from(node));
    let all: Vec<BoardSetup> =
        (PRIME..=last).map(of).chain([setup(SECOND, -31.0, place(last + 1), 20)]).collect();
    flight(&all)
}

/// Returns the changes of the role of a master board after `from` in its log.
fn roles(flight: &Recording, node: u8, from: Time) -> Vec<(Time, &str)> {
    let board = flight.board(node);
    let lines = flight.logs.iter().filter(|log| log.board == board && log.at > from);
    lines.filter_map(|log| Some((log.at, log.text.strip_prefix("this master board: ")?))).collect()
}

/// Asserts that since `from` prime is active and the other board silent, and that all slaves are Operational on `bus`.
fn assert_prime_serves_all(flight: &Flight, slaves: u8, bus: Bus, from: Time) {
    for node in [PRIME, SECOND] {
        assert_eq!(roles(flight, node, from), [], "{}", flight.log(node));
    }
    let [prime, second] = [PRIME, SECOND].map(|node| flight.board(node));
    assert!(is_active(flight, prime) && !is_active(flight, second));
    let last = flight.heartbeats(PRIME, bus).last().unwrap().0;
    assert!(flight.end.since(last) < ms(110), "{} us", last.as_us());
    assert_eq!(flight.driven(SECOND, from), 0);
    flight.assert_operational(2..=slaves + 1, bus);
    flight.assert_sound();
}

/// Given a standby that was restarted at 2 s, when a cut of the nominal bus at 4 s leaves one or two of five slaves and it without a
/// master, then it stays silent, and the active master moves to the bus of all slaves.
///
/// Verifies: ECSS 8.1a
#[test]
fn standby_cut_off_with_some_slaves_stays_silent() {
    const SLAVES: u8 = 5;
    for cut_at_m in [11.0, 9.0] {
        let mut flight = pair(SLAVES);
        flight.fly_to(2_000);
        flight.reset(SECOND);
        flight.fly_to(4_000);
        flight.assert_said(SECOND, "Standby (MasterHeard)", ms(2_000));
        flight.twin.wire_mut(Bus::Nominal).cut(cut_at_m);
        flight.fly_to(9_000);
        println!("cut at {cut_at_m} m");
        assert_prime_serves_all(&flight, SLAVES, Bus::Redundant, ms(4_000));
    }
}

/// Given a standby that lost its stub of the nominal bus at 2 s, when a foreign node sends the heartbeat of the master there one second
/// or four seconds later, five times, then no board changes its role.
///
/// Verifies: ECSS 8.1a
#[test]
fn foreign_master_after_a_lost_stub_moves_no_role() {
    const SLAVES: u8 = 2;
    const BEATS: u64 = 5;
    for foreign_ms in [3_000, 6_000] {
        let mut flight = pair(SLAVES);
        let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
        flight.twin.set_presence(guest, Presence::Away);
        flight.fly_to(2_000);
        let stub = Fault::Disconnect(flight.board(SECOND).0);
        flight.twin.wire_mut(Bus::Nominal).schedule(ms(2_000), stub).unwrap();
        flight.fly_to(foreign_ms);
        flight.twin.set_presence(guest, Presence::Present);
        for beat in 0..BEATS {
            let at = ms(foreign_ms + 1_000 * beat);
            flight.twin.inject(guest, at, WireFrame::standard(0x701, &[OPERATIONAL]));
        }
        flight.fly_to(foreign_ms + 1_000 * BEATS);
        let foreign = flight.on(Bus::Nominal).filter(|seen| seen.sender == guest.node);
        assert_eq!(foreign.count() as u64, BEATS, "from {foreign_ms} ms on");
        println!("a foreign master from {foreign_ms} ms on");
        assert_prime_serves_all(&flight, SLAVES, Bus::Nominal, ms(2_000));
    }
}

/// Returns the time at which a master board takes part in the nominal bus again after `from`: at once, unless it is
/// bus-off.
fn hears_nominal_from(flight: &Recording, node: u8, from: Time) -> Time {
    let board = flight.board(node);
    let states =
        flight.logs.iter().filter(|log| log.board == board && log.text.starts_with("Nominal: error "));
    let is_off = |log: &&LogRecord| log.text.contains("BusOff");
    let (before, after): (Vec<_>, Vec<_>) = states.partition(|log| log.at <= from);
    match before.last().filter(|log| is_off(log)) {
        Some(_) => after.iter().find(|log| !is_off(log)).unwrap().at,
        None => from,
    }
}

/// Given a redundant bus that is permanently shorted, when the nominal one is shorted for 300 ms, then the standby
/// takes over while the active master is bus-off. It yields within two heartbeat periods and 20 ms of collisions after
/// both have left bus-off.
///
/// Verifies: ECSS 8.1a
#[test]
fn masters_after_a_short_of_both_buses_become_one() {
    const SLAVES: u8 = 2;
    const HEARTBEAT: Time = ms(100);
    const COLLISIONS: Time = ms(20);
    let mut flight = pair(SLAVES);
    flight.fly_to(3_500);
    let short = Fault::Short { position_m: 6.0, level: true };
    let healed = ms(4_300);
    flight.twin.wire_mut(Bus::Redundant).schedule(ms(3_500), short).unwrap();
    flight.twin.wire_mut(Bus::Nominal).schedule(ms(4_000), short).unwrap();
    flight.twin.wire_mut(Bus::Nominal).schedule(healed, Fault::ClearShorts).unwrap();
    flight.fly_to(6_000);
    let texts = |node| roles(&flight, node, ms(3_500)).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
    assert_eq!(texts(PRIME), <Vec<&str>>::new(), "{}", flight.log(PRIME));
    let expected = ["Active on Nominal (MasterSilent)", "Standby (Yielded)"];
    assert_eq!(texts(SECOND), expected, "{}", flight.log(SECOND));
    let [prime, second] = [PRIME, SECOND].map(|node| hears_nominal_from(&flight, node, healed));
    let [(taken, _), (yielded, _)] = roles(&flight, SECOND, ms(3_500))[..] else { panic!("two roles") };
    let both = yielded.since(prime.max(second).max(taken));
    assert!(both <= HEARTBEAT + HEARTBEAT + COLLISIONS, "{} us", both.as_us());
    assert_prime_serves_all(&flight, SLAVES, Bus::Nominal, yielded + ms(1));
}

/// Given an active master whose claims drive it into bus-off on the redundant bus, which is short, when that bus is failed, then the
/// core sleeps: it is awake for less than a twentieth of the time.
#[test]
fn core_of_a_master_sleeps_while_a_bus_is_failed() {
    const CYCLES_PER_MS: u64 = 168_000;
    const SPAN_MS: u64 = 500;
    let mut flight = pair(2);
    flight.fly_to(1_500);
    let short = Fault::Short { position_m: 6.0, level: true };
    flight.twin.wire_mut(Bus::Redundant).schedule(ms(1_500), short).unwrap();
    flight.fly_to(1_700);
    flight.assert_said(PRIME, "Redundant failed", ms(1_500));
    let awake = |flight: &Flight| flight.emulated(PRIME).counters().cycles_awake;
    let before = awake(&flight);
    flight.fly_to(1_700 + SPAN_MS);
    let spent = awake(&flight) - before;
    assert!(spent < CYCLES_PER_MS * SPAN_MS / 20, "{spent} cycles in {SPAN_MS} ms");
}
