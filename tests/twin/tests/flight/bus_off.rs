//! The master is driven into bus-off and comes back.

use can_wire::frame::WireFrame;
use can_wire::time::Time;
use twin::spacecraft::Bus;

use crate::craft::*;

/// ISO 11898-1: 128 times 11 recessive bits, at 1 Mbit/s on an idle bus.
const RECOVERY_US: u64 = 1408;

/// A guest sends the master's COB-ID with other data: each meeting is a bit error for both, 32 of them are bus-off. The
/// master is alone with its slaves again after the pause of its policy and the recovery sequence; nobody changes the bus.
///
/// Verifies: ECSS 5.6.2b
/// Verifies: ECSS 5.6.2c
#[test]
fn the_master_recovers_from_bus_off_and_keeps_its_slaves() {
    let mut craft = Craft::new(&MASTER_AND_THREE);
    let guest = craft.twin.add_guest(Bus::Nominal, 30.0);
    craft.fly_to(1000);
    let (last, _) = *craft.heartbeats(1, Bus::Nominal).last().unwrap();
    // The guest keeps the bus busy over the instant of the next heartbeat, so that both want it at once afterwards.
    for _ in 0..16 {
        craft.twin.inject(guest, last + ms(249), WireFrame::standard(0x010, &[0x55; 8]));
    }
    // Once error passive the master pauses after each of its attempts and the guest gets through: it needs many frames.
    for _ in 0..24 {
        craft.twin.inject(guest, last + ms(249), WireFrame::standard(0x701, &[0x7E]));
    }
    craft.fly_to(3500);

    let off = craft.said(1, "Nominal: error BusOff", last).unwrap_or_else(|| panic!("{}", craft.log(1)));
    let back = craft.said(1, "Nominal: error Active", off).unwrap_or_else(|| panic!("{}", craft.log(1)));
    let pause = ms(10);
    let recovered = pause + Time::from_us(RECOVERY_US);
    // Slaves may talk meanwhile, and the driver looks every millisecond.
    assert!((recovered..recovered + ms(3)).contains(&back.since(off)), "{} us", back.since(off).as_us());
    for node in [2, 3, 4] {
        assert!(craft.is_operational(node, Bus::Nominal), "node {node}\n{}", craft.log(node));
        assert!(!craft.fell_back(node, last), "node {node}\n{}", craft.log(node));
    }
    assert!(craft.said(1, "active bus", last).is_none(), "{}", craft.log(1));
    craft.assert_nothing_lost();
}

/// A guest that never stops sending the master's COB-ID meets it again as soon as it is back.
fn besieged(frames: usize) -> (Craft, Time) {
    let mut craft = Craft::new(&MASTER_AND_THREE);
    let guest = craft.twin.add_guest(Bus::Nominal, 30.0);
    craft.fly_to(1000);
    let (last, _) = *craft.heartbeats(1, Bus::Nominal).last().unwrap();
    for _ in 0..16 {
        craft.twin.inject(guest, last + ms(249), WireFrame::standard(0x010, &[0x55; 8]));
    }
    for _ in 0..frames {
        craft.twin.inject(guest, last + ms(249), WireFrame::standard(0x701, &[0x7E]));
    }
    craft.fly_to(3500);
    (craft, last)
}

/// When the master said that it is bus-off on the nominal bus (`true`), or error active again.
fn changes(craft: &Craft) -> Vec<(Time, bool)> {
    let master = craft.board(MASTER);
    let said = craft.logs.iter().filter(|log| log.board == master);
    said.filter_map(|log| match () {
        () if log.text.contains("Nominal: error BusOff") => Some((log.at, true)),
        () if log.text.contains("Nominal: error Active, TEC 0,") => Some((log.at, false)),
        () => None,
    })
    .collect()
}

/// The heartbeat that waits goes out as soon as the controller is back, into the next collision.
///
/// Verifies: ECSS 5.6.2b
#[test]
fn every_bus_off_of_two_in_a_row_is_told_and_recovered() {
    let (mut craft, last) = besieged(450);
    let changes = changes(&craft);
    let off: Vec<bool> = changes.iter().map(|(_, off)| *off).collect();
    assert_eq!(off, [true, false, true, false], "{changes:?}\n{}", craft.log(1));
    // Each of them has its pause, and not before it the recovery.
    for pair in changes.chunks(2) {
        assert!(pair[1].0.since(pair[0].0) > ms(10), "{changes:?}");
    }
    assert!(craft.said(1, "active bus", last).is_none(), "{}", craft.log(1));
    for node in [2, 3, 4] {
        assert!(craft.is_operational(node, Bus::Nominal), "node {node}\n{}", craft.log(node));
    }
    craft.assert_nothing_lost();
}

/// Three recoveries in a window are allowed; the fourth bus-off fails the bus, and the slaves are taken to the other.
///
/// Verifies: ECSS 8.3.3b
#[test]
fn a_bus_that_the_master_cannot_stay_on_is_left() {
    let (mut craft, last) = besieged(2000);
    let failed = craft.said(1, "Nominal failed: bus-off too often", last);
    let failed = failed.unwrap_or_else(|| panic!("{}", craft.log(1)));
    let off = changes(&craft).into_iter().filter(|(at, off)| *off && *at <= failed).count();
    assert_eq!(off, 4, "{}", craft.log(1));
    assert!(craft.said(1, "active bus: Redundant", last).unwrap() < failed + ms(1), "{}", craft.log(1));
    for node in [2, 3] {
        assert!(craft.is_operational(node, Bus::Redundant), "node {node}\n{}", craft.log(node));
        assert!(!craft.fell_back(node, last), "node {node}\n{}", craft.log(node));
    }
    craft.assert_nothing_lost();
}
