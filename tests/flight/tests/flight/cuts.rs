//! Cut buses: detection, changes of the bus, and no stale frames afterwards.

use std::sync::LazyLock;

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use flight::*;

/// Heartbeat period, and the time in which the master detects missing acknowledgements.
const DETECTION: Time = Time::from_ms(250 + 5);
/// Ttoggle consumer times.
const TOGGLING: Time = Time::from_ms(12_500);
const TOLERANCE: Time = Time::from_ms(625);

const CUT: Time = Time::from_ms(2013);

/// The nominal bus breaks next to the master, shortly before commands are due.
static FLIGHT: LazyLock<Recording> =
    LazyLock::new(|| Flight::new(&MASTER_AND_THREE).cut_next_to_master(CUT, 15_500));

/// Returns the start of the master's first frame on the redundant bus.
fn detection(recording: &Recording) -> Time {
    recording.on(Bus::Redundant).find(|seen| seen.sender == 0).unwrap().start
}

/// Verifies: ECSS 8.3.3b
/// Verifies: ECSS 8.3.3b.1
/// Verifies: ECSS 8.3.3b.2
#[test]
fn the_master_changes_the_bus_when_its_own_is_cut() {
    let detection = detection(&FLIGHT);
    assert!(detection.since(CUT) < DETECTION, "{} us", detection.since(CUT).as_us());
    let first = FLIGHT.on(Bus::Redundant).next().unwrap();
    assert_eq!((first.sender, first.id(), first.data()), (0, Some(0x701), &[OPERATIONAL][..]));
    let told = FLIGHT.said(1, "Isolated", CUT).unwrap();
    assert!(told < detection + ms(1));
    // The current attempt ends. No further one starts on the cut bus.
    assert!(FLIGHT.attempts(1, Bus::Nominal).all(|at| at < detection + ms(1)));
    assert!(!FLIGHT.of(MASTER).any(|seen| seen.bus == Bus::Nominal && seen.end > CUT));
}

/// Verifies: ECSS 8.3.3b, 8.3.3g
#[test]
fn detection_does_not_depend_on_the_moment_of_the_cut() {
    let mut before = Flight::new(&MASTER_AND_THREE[..3]);
    for cut in [701, 745, 790] {
        before.fly_to(cut);
        let mut flight = before.clone();
        flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        flight.fly_to(cut + 600);
        let taken = detection(&flight).since(ms(cut));
        assert!(taken < DETECTION, "cut at {cut} ms: {} us", taken.as_us());
        flight.assert_operational([2, 3], Bus::Redundant);
        flight.assert_nothing_lost();
    }
}

/// Verifies: ECSS 8.2.1a.2
/// Verifies: ECSS 8.3.3d
/// Verifies: ECSS 8.3.3g
#[test]
fn parallel_slaves_follow_at_the_first_message_of_the_master() {
    let announced = FLIGHT.on(Bus::Redundant).next().unwrap().end;
    for node in [2, 3] {
        let (followed, state) = FLIGHT.heartbeats(node, Bus::Redundant)[0];
        assert!(followed > announced && followed < announced + ms(1), "node {node}: {} us", followed.as_us());
        assert_eq!(state, OPERATIONAL);
        assert!(!FLIGHT.fell_back(node, ms(300)), "node {node} stays operational all the time");
        let left = FLIGHT.heartbeats(node, Bus::Nominal);
        assert!(left.iter().all(|(at, _)| *at < followed), "node {node} has left the nominal bus");
        assert!(FLIGHT.is_operational(node, Bus::Redundant), "node {node}");
    }
}

/// Verifies: ECSS 8.3.3b
#[test]
fn commands_flow_within_10_ms_of_the_detection() {
    let detection = detection(&FLIGHT);
    let command = FLIGHT.first_after(detection, |seen| {
        seen.bus == Bus::Redundant && matches!(seen.id(), Some(0x302 | 0x303))
    });
    assert!(command.unwrap().end < detection + ms(10), "{} us", command.unwrap().end.as_us());
    for node in [2_u8, 3] {
        let sent = |function| FLIGHT.sent(MASTER, Bus::Redundant, function + u16::from(node)).count() as u64;
        let flow = sent(0x300) + sent(0x400);
        let expected = 2 * (FLIGHT.end.since(detection).as_us() / 100_000);
        assert!(flow.abs_diff(expected) <= 2, "node {node}: {flow} of {expected}");
    }
}

fn last_master_message_of_slave_4() -> Time {
    FLIGHT.heartbeats(MASTER, Bus::Nominal).last().unwrap().0
}

/// Verifies: ECSS 8.3.3e
/// Verifies: ECSS 8.3.3e.1
/// Verifies: ECSS 8.3.3e.2
/// Verifies: ECSS 8.3.3c
/// Verifies: ECSS 8.3.3h
#[test]
fn selective_slave_searches_when_the_master_is_missed() {
    let last = last_master_message_of_slave_4();
    let fallen = FLIGHT.heartbeats(4, Bus::Nominal).into_iter().find(|(_, state)| *state == PRE_OPERATIONAL);
    let fallen = fallen.unwrap().0.since(last);
    // The consumer time, and at most one period until its next heartbeat shows the state.
    assert!(fallen > ms(2499) && fallen < ms(2500 + 251), "{} us", fallen.as_us());
    let (toggled, state) = FLIGHT.heartbeats(4, Bus::Redundant)[0];
    assert!(about(TOGGLING, TOLERANCE).contains(&toggled.since(last)), "{} us", toggled.since(last).as_us());
    assert_eq!(state, PRE_OPERATIONAL);
    assert!(FLIGHT.heartbeats(4, Bus::Nominal).iter().all(|(at, _)| *at < toggled));
}

/// Verifies: ECSS 8.2.1a.1
#[test]
fn selective_slave_takes_part_in_one_bus_at_a_time() {
    let toggled = FLIGHT.heartbeats(4, Bus::Redundant)[0].0;
    for seen in FLIGHT.on(Bus::Redundant).filter(|seen| seen.sender != 3) {
        assert_eq!(seen.reached.contains(&4), seen.end > toggled, "{seen:?}");
    }
    // The slaves with parallel access would acknowledge on the old bus, so each frame there would complete. None is
    // sent.
    assert_eq!(FLIGHT.on(Bus::Nominal).filter(|seen| seen.end > toggled).count(), 0);
}

/// Verifies: ECSS 8.3.3f, 6.5.1a.1
#[test]
fn the_master_starts_a_slave_that_has_changed_the_bus_unasked() {
    let toggled = FLIGHT.heartbeats(4, Bus::Redundant)[0].0;
    let start = FLIGHT.first_after(toggled, |seen| seen.id() == Some(0) && seen.data() == [1, 4]).unwrap();
    assert_eq!((start.bus, start.sender), (Bus::Redundant, 0));
    let (operational, state) = FLIGHT.heartbeats(4, Bus::Redundant)[1];
    assert_eq!(state, OPERATIONAL);
    assert!(operational > start.end && operational < toggled + ms(5), "{} us", operational.as_us());
    assert!(FLIGHT.is_operational(4, Bus::Redundant));
    let command = FLIGHT.first_after(operational, |seen| seen.id() == Some(0x304)).unwrap();
    assert!(command.reached.contains(&4) && command.end < operational + ms(100));
}

fn cut_both(flight: &mut Flight) {
    Bus::ALL.into_iter().for_each(|bus| flight.twin.wire_mut(bus).cut(NEXT_TO_MASTER_M));
}

fn restore_both(flight: &mut Flight) {
    Bus::ALL.into_iter().for_each(|bus| flight.twin.wire_mut(bus).restore_all());
}

fn active_bus(flight: &Flight) -> Bus {
    flight.frames.iter().rfind(|seen| seen.sender == 0).unwrap().bus
}

/// Both buses are cut for 4 s, longer than the consumer time.
///
/// Verifies: ECSS 8.3.3e.1, 8.3.3f, 6.5.2b
#[test]
fn both_buses_cut_and_restored() {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(1000);
    cut_both(&mut flight);
    let last_heard = flight.heartbeats(MASTER, Bus::Nominal).last().unwrap().0;
    flight.fly_to(5000);
    for node in [2, 3, 4] {
        let (_, state) = *flight.heartbeats(node, Bus::Nominal).last().unwrap();
        assert_eq!(state, PRE_OPERATIONAL, "node {node} has missed its master");
    }
    restore_both(&mut flight);
    flight.fly_to(5400);
    let active = active_bus(&flight);
    flight.assert_operational([2, 3], active);
    for node in [2, 3] {
        let started =
            flight.heartbeats(node, active).into_iter().find(|(at, s)| *at > ms(5000) && *s == OPERATIONAL);
        assert!(started.unwrap().0 < ms(5010), "node {node}: {} us", started.unwrap().0.as_us());
    }
    // Slave 4 listens on one bus, and changes it after its toggling time.
    flight.fly(last_heard + TOGGLING + TOLERANCE);
    flight.assert_operational([2, 3, 4], active);
    assert_eq!(active_bus(&flight), active, "the master does not go to and fro");
    flight.assert_nothing_lost();
}

/// Frames wait on both sides of the cuts when they heal.
///
/// Verifies: ECSS 8.3.3a, 6.5.2b, 8.3.3c
#[test]
fn an_outage_shorter_than_the_consumer_time_costs_no_state() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    flight.fly_to(1000);
    cut_both(&mut flight);
    flight.fly_to(2200);
    restore_both(&mut flight);
    flight.fly_to(3000);
    let active = active_bus(&flight);
    flight.assert_kept_running([2, 3], ms(300));
    flight.assert_operational([2, 3], active);
    assert_fresh_commands(&flight, ms(1000), ms(2200));
    // One heartbeat may have waited when the cuts healed, the next one is due within a period.
    let after: Vec<Time> =
        flight.heartbeats(MASTER, active).into_iter().map(|(at, _)| at).filter(|at| *at > ms(2200)).collect();
    assert!(after[0] < ms(2202) && after[1] < ms(2452), "{after:?}");
    assert!(gaps(&after[1..]).all(|gap| about(ms(250), ms(1)).contains(&gap)), "{after:?}");
    flight.assert_nothing_lost();
}

/// Every command that sets a value carries the number of its turn, and turns come every 100 ms: a command to slaves 2 and 3 that
/// waited longer than that would carry too small a number.
fn assert_fresh_commands(flight: &Flight, before: Time, after: Time) {
    for id in [0x302, 0x303] {
        let sets = flight.with_id(id).filter(|seen| seen.data()[..2] == [2, 0]);
        let turn = |seen: &Seen| u64::from(u32::from_le_bytes(seen.data()[2..6].try_into().unwrap()));
        let turns: Vec<(Time, u64)> = sets.map(|seen| (seen.end, turn(seen))).collect();
        let (first_at, first) = turns[0];
        assert!(first_at < before && turns.iter().any(|(at, _)| *at > after));
        for (at, turn) in turns {
            let due = first_at + ms(100 * (turn - first));
            assert!(at < due + ms(101), "{id:03X}h, turn {turn}: {} us late", at.since(due).as_us());
        }
    }
}

/// Verifies: ECSS 8.3.3b.1, 8.3.3d
#[test]
fn nothing_stale_comes_from_the_master_when_a_cut_heals() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    flight.fly_to(1000);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(1400);
    let detection = detection(&flight);
    assert!(flight.attempts(1, Bus::Nominal).count() > 16, "frames were pending on the cut bus");
    flight.twin.wire_mut(Bus::Nominal).restore_all();
    flight.fly_to(2200);
    assert!(!flight.of(MASTER).any(|seen| seen.bus == Bus::Nominal && seen.end > ms(1000)));
    assert!(flight.attempts(1, Bus::Nominal).all(|at| at < detection + ms(1)));
    for node in [2, 3] {
        let left = flight.heartbeats(node, Bus::Nominal);
        assert!(left.iter().all(|(at, _)| *at < detection + ms(1)), "nobody was called back");
    }
    flight.assert_operational([2, 3], Bus::Redundant);
    assert_fresh_commands(&flight, ms(1000), ms(1400));
    flight.assert_nothing_lost();
}

/// Given a cut that heals before the master has detected it, then the master stays on the bus, and pending frames are
/// still valid.
#[test]
fn a_cut_that_heals_before_it_is_detected_changes_nothing() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..3]);
    flight.fly_to(1000);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    while flight.attempts(1, Bus::Nominal).filter(|at| *at > ms(1000)).count() < 3 {
        flight.fly(flight.end + Time::from_us(10));
    }
    flight.twin.wire_mut(Bus::Nominal).restore_all();
    let healed = flight.end;
    flight.fly_to(2000);
    assert_eq!(flight.on(Bus::Redundant).count(), 0);
    let next = flight.first_after(healed, |seen| seen.sender == 0).unwrap();
    assert!(next.end < healed + ms(1), "the frame that waited");
    flight.assert_operational([2, 3], Bus::Nominal);
    flight.assert_kept_running([2, 3], ms(300));
    flight.assert_nothing_lost();
}

/// Given the only slave, cut off between a request and its answer, then no stale frame follows. The lifetime of the
/// answer is the period of requests.
#[test]
fn nothing_stale_comes_from_a_slave_when_a_cut_heals() {
    let mut flight = Flight::new(&MASTER_AND_THREE[..2]);
    flight.fly_to(1000);
    let request = flight.fly_until(|seen| seen.id() == Some(0x402));
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly(request.end + ms(150));
    assert!(flight.attempts(2, Bus::Nominal).count() > 16, "the answer was pending");
    flight.twin.wire_mut(Bus::Nominal).restore_all();
    let healed = flight.end;
    flight.fly_to(2000);
    let mut asked = Vec::new();
    for seen in flight.frames.iter().filter(|seen| seen.end > healed) {
        match seen.id() {
            Some(0x402) => asked.push(seen.data()[..2].to_vec()),
            Some(0x382) => assert!(asked.contains(&seen.data()[..2].to_vec()), "nobody asked for {seen:?}"),
            _ => {}
        }
    }
    assert!(asked.len() > 5);
    flight.assert_nothing_lost();
}

/// Given slave 2, isolated on both buses for 2 s, then only one heartbeat, which is younger than a period, is still
/// pending.
///
/// Verifies: ECSS 8.3.3d
#[test]
fn heartbeats_of_a_slave_do_not_pile_up_on_a_cut_bus() {
    let mut setups = MASTER_AND_THREE;
    setups[1].position_m = 30.0;
    let mut flight = Flight::new(&setups[..3]);
    flight.fly_to(1000);
    Bus::ALL.into_iter().for_each(|bus| flight.twin.wire_mut(bus).cut(25.0));
    flight.fly_to(3000);
    assert!(flight.heartbeats(2, Bus::Nominal).iter().all(|(at, _)| *at < ms(1000)));
    restore_both(&mut flight);
    flight.fly_to(3600);
    let all = Bus::ALL.into_iter().flat_map(|bus| flight.heartbeats(2, bus));
    let after: Vec<Time> = all.map(|(at, _)| at).filter(|at| *at > ms(3000)).collect();
    assert!((2..=4).contains(&after.len()), "{after:?}");
    assert!(gaps(&after[1..]).all(|gap| gap > ms(200)), "{after:?}");
    flight.assert_nothing_lost();
}
