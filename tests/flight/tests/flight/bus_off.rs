//! The master is driven into bus-off and comes back.

use can_twin::spacecraft::Bus;
use can_twin::wire::fault::{Effect, Fault, Nodes};
use can_twin::wire::time::Time;
use flight::*;

/// ISO 11898-1: 128 times 11 recessive bits, at 1 Mbit/s on an idle bus.
const RECOVERY_US: u64 = 1408;

/// Flies with a master whose receiver on the nominal bus is deaf from just before a heartbeat on.
fn deaf_for(duration: Time) -> (Flight, Time) {
    let mut flight = Flight::new(&MASTER_AND_THREE);
    flight.fly_to(1000);
    let (last, _) = *flight.heartbeats(1, Bus::Nominal).last().unwrap();
    let nodes = Nodes::of(&[flight.board(1).0]);
    let deaf = Fault::Glitch { nodes, duration, effect: Effect::Recessive };
    flight.twin.wire_mut(Bus::Nominal).schedule(last + ms(249), deaf).unwrap();
    flight.fly_to(3500);
    (flight, last)
}

/// Given a master whose receiver is deaf for two milliseconds while it sends, when each dominant bit is a bit error,
/// then its counter reaches bus-off. After the pause of its policy and the recovery sequence it communicates again, and
/// no node changes the bus.
///
/// Verifies: ECSS 5.6.2a
/// Verifies: ECSS 5.6.2b
#[test]
fn the_master_recovers_from_bus_off_and_keeps_its_slaves() {
    let (mut flight, last) = deaf_for(ms(2));
    let off = flight.assert_said(1, "Nominal: error BusOff", last);
    let back = flight.assert_said(1, "Nominal: error Active", off);
    let recovered = ms(10) + Time::from_us(RECOVERY_US);
    // Slaves may send meanwhile, and the driver polls every millisecond.
    assert!((recovered..recovered + ms(3)).contains(&back.since(off)), "{} us", back.since(off).as_us());
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    flight.assert_kept_running([2, 3, 4], last);
    assert!(flight.said(1, "active bus", last).is_none(), "{}", flight.log(1));
    flight.assert_nothing_lost();
}

/// Returns the times at which the master logged bus-off on the nominal bus (`true`), or error active again.
fn changes(flight: &Flight) -> Vec<(Time, bool)> {
    let master = flight.board(MASTER);
    let said = flight.logs.iter().filter(|log| log.board == master);
    said.filter_map(|log| match () {
        () if log.text.contains("Nominal: error BusOff") => Some((log.at, true)),
        () if log.text.contains("Nominal: error Active, TEC 0,") => Some((log.at, false)),
        () => None,
    })
    .collect()
}

/// Given a receiver that stays deaf, when the controller is back, then the pending heartbeat causes the next bus-off at
/// once, and each bus-off is reported and recovered.
///
/// Verifies: ECSS 5.6.2a, 5.6.2b
#[test]
fn every_bus_off_of_two_in_a_row_is_told_and_recovered() {
    let (mut flight, last) = deaf_for(ms(16));
    let changes = changes(&flight);
    let off: Vec<bool> = changes.iter().map(|(_, off)| *off).collect();
    assert_eq!(off, [true, false, true, false], "{changes:?}\n{}", flight.log(1));
    // The recovery of each one follows its pause.
    for pair in changes.chunks(2) {
        assert!(pair[1].0.since(pair[0].0) > ms(10), "{changes:?}");
    }
    assert!(flight.said(1, "active bus", last).is_none(), "{}", flight.log(1));
    flight.assert_operational([2, 3, 4], Bus::Nominal);
    flight.assert_nothing_lost();
}

/// Three recoveries in a window are allowed; the fourth bus-off fails the bus, and the slaves are taken to the other.
///
/// Verifies: ECSS 8.3.3b, 8.3.3g
#[test]
fn a_bus_that_the_master_cannot_stay_on_is_left() {
    let (mut flight, last) = deaf_for(ms(100));
    let failed = flight.assert_said(1, "Nominal failed: bus-off too often", last);
    let off = changes(&flight).into_iter().filter(|(at, off)| *off && *at <= failed).count();
    assert_eq!(off, 4, "{}", flight.log(1));
    assert!(flight.assert_said(1, "active bus: Redundant", last) < failed + ms(1), "{}", flight.log(1));
    flight.assert_operational([2, 3], Bus::Redundant);
    flight.assert_kept_running([2, 3], last);
    flight.assert_nothing_lost();
}
