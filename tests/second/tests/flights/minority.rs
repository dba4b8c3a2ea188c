//! A cut that loses fewer slaves than the share that makes the master leave at once.

use can_wire::time::Time;
use twin::spacecraft::Bus;

use flight::*;

/// Slave 2 to the left of the master, slave 4 far to the right.
const SPREAD: [BoardSetup; 4] = [
    BoardSetup { position_m: 4.0, ..MASTER_AND_THREE[0] },
    BoardSetup { position_m: 0.0, ..MASTER_AND_THREE[1] },
    BoardSetup { position_m: 8.0, ..MASTER_AND_THREE[2] },
    BoardSetup { position_m: 23.0, ..MASTER_AND_THREE[3] },
];
const LEFT_OF_MASTER_M: f64 = 2.0;
const LEFT_OF_FOUR_M: f64 = 20.0;
const CUT: Time = Time::from_ms(1_013);

/// When the master changed the bus, by its first words there.
fn switches(flight: &Flight) -> Vec<(Time, Bus)> {
    let mut switches: Vec<(Time, Bus)> = Vec::new();
    for seen in flight.frames.iter().filter(|seen| seen.sender == 0) {
        if switches.last().is_none_or(|(_, bus)| *bus != seen.bus) {
            switches.push((seen.end, seen.bus));
        }
    }
    switches.split_off(1)
}

/// Consumer time 250 ms, Ttoggle 2: slave 4 is on the other bus 500 ms after the cut.
#[test]
fn a_lost_minority_is_found_on_the_other_bus() {
    let mut flight = Flight::with(&SPREAD, &STANDARD);
    flight.fly(CUT);
    flight.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    flight.fly(CUT + ms(1_600));
    for node in [2, 3, 4] {
        assert!(flight.is_operational(node, Bus::Redundant), "{}\n{}", flight.log(1), flight.log(node));
        assert!(node == 4 || !flight.fell_back(node, CUT));
    }
    flight.fly_to(12_000);
    assert_eq!(switches(&flight).len(), 1, "it stays where all are heard\n{}", flight.log(1));
    flight.assert_nothing_lost();
}

/// Slave 4 has selective access: it is on the other bus 12.5 s after the last heartbeat that it heard.
#[test]
fn a_lost_selective_slave_is_found_on_the_other_bus() {
    let mut flight = Flight::new(&SPREAD);
    flight.fly(CUT);
    flight.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    flight.fly(CUT + ms(26_000));
    for node in [2, 3, 4] {
        assert!(flight.is_operational(node, Bus::Redundant), "{}\n{}", flight.log(1), flight.log(node));
        assert!(node == 4 || !flight.fell_back(node, CUT));
    }
    assert_eq!(switches(&flight).len(), 1, "{}", flight.log(1));
    flight.assert_nothing_lost();
}

/// Each bus reaches two of three slaves: one try from each, and no going to and fro.
#[test]
fn of_two_buses_that_reach_as_many_each_is_tried_once() {
    let mut flight = Flight::with(&SPREAD, &STANDARD);
    flight.fly(CUT);
    flight.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    flight.twin.wire_mut(Bus::Redundant).cut(LEFT_OF_MASTER_M);
    flight.fly_to(12_000);
    let switches: Vec<Bus> = switches(&flight).into_iter().map(|(_, bus)| bus).collect();
    assert_eq!(switches, [Bus::Redundant, Bus::Nominal], "{}", flight.log(1));
    for node in [2, 3] {
        assert!(flight.is_operational(node, Bus::Nominal), "{}", flight.log(node));
    }
    flight.assert_nothing_lost();
}

/// The other bus reaches slave 4 alone: the master is back after the settling time, and does not try again.
#[test]
fn a_try_that_loses_more_slaves_is_undone_and_not_repeated() {
    let mut setups = SPREAD;
    setups[2].position_m = 1.0;
    let mut flight = Flight::with(&setups, &STANDARD);
    flight.fly(CUT);
    flight.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    flight.twin.wire_mut(Bus::Redundant).cut(LEFT_OF_MASTER_M);
    flight.fly_to(12_000);
    let switches = switches(&flight);
    let buses: Vec<Bus> = switches.iter().map(|(_, bus)| *bus).collect();
    assert_eq!(buses, [Bus::Redundant, Bus::Nominal], "{}", flight.log(1));
    let there = switches[1].0.since(switches[0].0);
    assert!(there < ms(710), "{} us", there.as_us());
    for node in [2, 3] {
        assert!(flight.is_operational(node, Bus::Nominal), "{}", flight.log(node));
    }
    flight.assert_nothing_lost();
}

/// Cut off from both buses, slave 4 is heard nowhere.
#[test]
fn a_slave_that_is_heard_nowhere_moves_nobody() {
    let mut flight = Flight::with(&SPREAD, &STANDARD);
    flight.fly(CUT);
    Bus::ALL.into_iter().for_each(|bus| flight.twin.wire_mut(bus).cut(LEFT_OF_FOUR_M));
    flight.fly_to(12_000);
    assert_eq!(switches(&flight), [], "{}", flight.log(1));
    for node in [2, 3] {
        assert!(flight.is_operational(node, Bus::Nominal) && !flight.fell_back(node, CUT));
    }
    flight.assert_nothing_lost();
}
