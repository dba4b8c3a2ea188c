//! A cut that loses fewer slaves than the share that makes the master leave at once.

use can_wire::time::Time;
use twin::spacecraft::Bus;

use flight::*;

/// Slave 2 to the left of the master, slave 4 far to the right.
const SPREAD: [Seat; 4] = [
    Seat { position_m: 4.0, ..MASTER_AND_THREE[0] },
    Seat { position_m: 0.0, ..MASTER_AND_THREE[1] },
    Seat { position_m: 8.0, ..MASTER_AND_THREE[2] },
    Seat { position_m: 23.0, ..MASTER_AND_THREE[3] },
];
const LEFT_OF_MASTER_M: f64 = 2.0;
const LEFT_OF_FOUR_M: f64 = 20.0;
const CUT: Time = Time::from_ms(1_013);

/// When the master changed the bus, by its first words there.
fn switches(craft: &Craft) -> Vec<(Time, Bus)> {
    let mut switches: Vec<(Time, Bus)> = Vec::new();
    for seen in craft.frames.iter().filter(|seen| seen.sender == 0) {
        if switches.last().is_none_or(|(_, bus)| *bus != seen.bus) {
            switches.push((seen.end, seen.bus));
        }
    }
    switches.split_off(1)
}

/// Consumer time 250 ms, Ttoggle 2: slave 4 is on the other bus 500 ms after the cut.
#[test]
fn a_lost_minority_is_found_on_the_other_bus() {
    let mut craft = Craft::with(&SPREAD, &STANDARD);
    craft.fly(CUT);
    craft.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    craft.fly(CUT + ms(1_600));
    for node in [2, 3, 4] {
        assert!(craft.is_operational(node, Bus::Redundant), "{}\n{}", craft.log(1), craft.log(node));
        assert!(node == 4 || !craft.fell_back(node, CUT));
    }
    craft.fly_to(12_000);
    assert_eq!(switches(&craft).len(), 1, "it stays where all are heard\n{}", craft.log(1));
    craft.assert_nothing_lost();
}

/// Slave 4 has selective access: it is on the other bus 12.5 s after the last heartbeat that it heard.
#[test]
fn a_lost_selective_slave_is_found_on_the_other_bus() {
    let mut craft = Craft::new(&SPREAD);
    craft.fly(CUT);
    craft.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    craft.fly(CUT + ms(26_000));
    for node in [2, 3, 4] {
        assert!(craft.is_operational(node, Bus::Redundant), "{}\n{}", craft.log(1), craft.log(node));
        assert!(node == 4 || !craft.fell_back(node, CUT));
    }
    assert_eq!(switches(&craft).len(), 1, "{}", craft.log(1));
    craft.assert_nothing_lost();
}

/// Each bus reaches two of three slaves: one try from each, and no going to and fro.
#[test]
fn of_two_buses_that_reach_as_many_each_is_tried_once() {
    let mut craft = Craft::with(&SPREAD, &STANDARD);
    craft.fly(CUT);
    craft.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    craft.twin.wire_mut(Bus::Redundant).cut(LEFT_OF_MASTER_M);
    craft.fly_to(12_000);
    let switches: Vec<Bus> = switches(&craft).into_iter().map(|(_, bus)| bus).collect();
    assert_eq!(switches, [Bus::Redundant, Bus::Nominal], "{}", craft.log(1));
    for node in [2, 3] {
        assert!(craft.is_operational(node, Bus::Nominal), "{}", craft.log(node));
    }
    craft.assert_nothing_lost();
}

/// The other bus reaches slave 4 alone: the master is back after the settling time, and does not try again.
#[test]
fn a_try_that_loses_more_slaves_is_undone_and_not_repeated() {
    let mut seats = SPREAD;
    seats[2].position_m = 1.0;
    let mut craft = Craft::with(&seats, &STANDARD);
    craft.fly(CUT);
    craft.twin.wire_mut(Bus::Nominal).cut(LEFT_OF_FOUR_M);
    craft.twin.wire_mut(Bus::Redundant).cut(LEFT_OF_MASTER_M);
    craft.fly_to(12_000);
    let switches = switches(&craft);
    let buses: Vec<Bus> = switches.iter().map(|(_, bus)| *bus).collect();
    assert_eq!(buses, [Bus::Redundant, Bus::Nominal], "{}", craft.log(1));
    let there = switches[1].0.since(switches[0].0);
    assert!(there < ms(710), "{} us", there.as_us());
    for node in [2, 3] {
        assert!(craft.is_operational(node, Bus::Nominal), "{}", craft.log(node));
    }
    craft.assert_nothing_lost();
}

/// Cut off from both buses, slave 4 is heard nowhere.
#[test]
fn a_slave_that_is_heard_nowhere_moves_nobody() {
    let mut craft = Craft::with(&SPREAD, &STANDARD);
    craft.fly(CUT);
    Bus::ALL.into_iter().for_each(|bus| craft.twin.wire_mut(bus).cut(LEFT_OF_FOUR_M));
    craft.fly_to(12_000);
    assert_eq!(switches(&craft), [], "{}", craft.log(1));
    for node in [2, 3] {
        assert!(craft.is_operational(node, Bus::Nominal) && !craft.fell_back(node, CUT));
    }
    craft.assert_nothing_lost();
}
