//! A cut that loses fewer slaves than the share that makes the master leave at once.

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
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

/// Returns the times at which the master changed the bus, by its first frames there.
fn switches(flight: &Flight) -> Vec<(Time, Bus)> {
    let mut switches: Vec<(Time, Bus)> = Vec::new();
    for seen in flight.frames.iter().filter(|seen| seen.sender == 0) {
        if switches.last().is_none_or(|(_, bus)| *bus != seen.bus) {
            switches.push((seen.end, seen.bus));
        }
    }
    switches.split_off(1)
}

/// Flies until the nominal bus is cut at this place, and the redundant one too, if it has a place.
fn cut(mut flight: Flight, nominal_m: f64, redundant_m: Option<f64>) -> Flight {
    flight.fly(CUT);
    flight.twin.wire_mut(Bus::Nominal).cut(nominal_m);
    redundant_m.into_iter().for_each(|place| flight.twin.wire_mut(Bus::Redundant).cut(place));
    flight
}

/// Profile `standard`, consumer time 250 ms, Ttoggle 2: slave 4 is on the other bus 500 ms after the cut. Profile
/// `librecube`: it has selective access and is there 12.5 s after the last heartbeat that it heard. The master stays on
/// the bus where all slaves are heard.
#[test]
fn a_lost_minority_is_found_on_the_other_bus() {
    let flights = [(Flight::with(&SPREAD, &STANDARD), 1_600, 12_000), (Flight::new(&SPREAD), 26_000, 27_013)];
    for (flight, within_ms, end_ms) in flights {
        let mut flight = cut(flight, LEFT_OF_FOUR_M, None);
        flight.fly(CUT + ms(within_ms));
        flight.assert_operational([2, 3, 4], Bus::Redundant);
        flight.assert_kept_running([2, 3], CUT);
        flight.fly_to(end_ms);
        assert_eq!(switches(&flight).len(), 1, "after {end_ms} ms\n{}", flight.log(1));
        flight.assert_nothing_lost();
    }
}

/// Given buses that each reach two of three slaves, then the master tries the other bus once, and does not alternate.
/// If the other bus reaches only slave 4, the master returns after the settling time, and does not try again.
#[test]
fn a_bus_that_reaches_no_more_slaves_is_tried_once() {
    for (place_of_three_m, back_within) in [(8.0, None), (1.0, Some(ms(710)))] {
        let mut setups = SPREAD;
        setups[2].position_m = place_of_three_m;
        let flight = Flight::with(&setups, &STANDARD);
        let mut flight = cut(flight, LEFT_OF_FOUR_M, Some(LEFT_OF_MASTER_M));
        flight.fly_to(12_000);
        let switches = switches(&flight);
        let buses: Vec<Bus> = switches.iter().map(|(_, bus)| *bus).collect();
        let expected = [Bus::Redundant, Bus::Nominal];
        assert_eq!(buses, expected, "slave 3 at {place_of_three_m} m\n{}", flight.log(1));
        let there = switches[1].0.since(switches[0].0);
        assert!(back_within.is_none_or(|most| there < most), "{} us", there.as_us());
        flight.assert_operational([2, 3], Bus::Nominal);
        flight.assert_nothing_lost();
    }
}

/// Given slave 4 cut off from both buses, then the master stays on its bus.
#[test]
fn a_slave_that_is_heard_nowhere_moves_nobody() {
    let flight = Flight::with(&SPREAD, &STANDARD);
    let mut flight = cut(flight, LEFT_OF_FOUR_M, Some(LEFT_OF_FOUR_M));
    flight.fly_to(12_000);
    assert_eq!(switches(&flight), [], "{}", flight.log(1));
    flight.assert_operational([2, 3], Bus::Nominal);
    flight.assert_kept_running([2, 3], CUT);
    flight.assert_nothing_lost();
}
