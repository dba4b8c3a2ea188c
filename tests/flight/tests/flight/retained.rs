//! The Bdefault that a slave found survives a reset and a loss of power.
//!
//! With a consumer time of 2.5 s, Bdefault is stored for a loss of power 2.5 s after the change of the bus.

use can_twin::spacecraft::{Bus, GuestId};
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

const SLAVE: u8 = 3;

/// Flies until the master and slaves 2 and 3 have left the nominal bus, which is cut next to the master at 1000 ms. A
/// guest is on the redundant bus.
fn on_redundant(until_ms: u64) -> (Flight, GuestId) {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Redundant);
    flight.fly_to(1000);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(until_ms);
    flight.assert_operational([2, SLAVE], Bus::Redundant);
    (flight, guest)
}

/// Flies on for 1500 ms, and returns time and bus of the boot-up message of node 3.
fn boot_up(flight: &mut Flight) -> Option<(Time, Bus)> {
    let from = flight.end;
    flight.fly(from + ms(1500));
    let said = Bus::ALL
        .into_iter()
        .flat_map(|bus| flight.heartbeats(SLAVE, bus).into_iter().map(move |(at, state)| (at, state, bus)));
    let mut booted = said.filter(|(at, state, _)| *at > from && *state == BOOT_UP);
    let first = booted.next().map(|(at, _, bus)| (at, bus));
    assert_eq!(booted.next(), None, "one boot-up message\n{}", flight.log(SLAVE));
    first
}

/// Pulls the reset pin of a node, or takes its power for 200 ms.
fn restart(flight: &mut Flight, node: u8, loses_power: bool) {
    if !loses_power {
        return flight.reset(node);
    }
    let board = flight.board(node);
    flight.twin.power(board, false);
    flight.fly(flight.end + ms(200));
    flight.twin.power(board, true);
}

/// Restarts node 3, and returns the bus on which it boots.
fn boots_on(flight: &mut Flight, loses_power: bool) -> Option<Bus> {
    restart(flight, SLAVE, loses_power);
    boot_up(flight).map(|(_, bus)| bus)
}

/// Writes an object of node 3 by an expedited download from a guest, and asserts that it is confirmed.
fn write(flight: &mut Flight, guest: GuestId, index: u16, sub: u8, value: &[u8]) {
    let [low, high] = index.to_le_bytes();
    let mut data = [0x23 | (4 - value.len() as u8) << 2, low, high, sub, 0, 0, 0, 0];
    data[4..4 + value.len()].copy_from_slice(value);
    assert_eq!(flight.ask(guest, SLAVE, data)[..4], [0x60, low, high, sub]);
}

/// Verifies: ECSS 8.3.2a, 6.5.3a, 8.3.3l
#[test]
fn a_slave_that_is_reset_starts_on_the_bus_it_found() {
    // Reset by its pin, and by a command on its current bus.
    for by_command in [false, true] {
        let (mut flight, guest) = on_redundant(1500);
        let from = flight.end;
        if by_command {
            flight.twin.inject(guest, from, WireFrame::standard(0x000, &[0x81, SLAVE]));
        } else {
            flight.reset(SLAVE);
        }
        let (booted, bus) = boot_up(&mut flight).unwrap();
        assert_eq!(bus, Bus::Redundant, "{}", flight.log(SLAVE));
        assert!(booted < from + ms(15), "{} us", booted.since(from).as_us());
        flight.assert_operational([SLAVE, 2], Bus::Redundant);
        flight.assert_sound();
    }
}

/// Verifies: ECSS 8.3.2a, 8.3.3l
#[test]
fn a_slave_without_power_starts_on_the_bus_it_found() {
    // The change of the bus is 1 s or 3 s old: less or more than a consumer time.
    for (until_ms, expected) in [(2000, Bus::Nominal), (4000, Bus::Redundant)] {
        println!("without power at {until_ms} ms");
        let (mut flight, _) = on_redundant(until_ms);
        assert_eq!(boots_on(&mut flight, true), Some(expected), "{until_ms} ms\n{}", flight.log(SLAVE));
        flight.assert_operational([SLAVE], Bus::Redundant);
        flight.assert_sound();
    }
}

/// Given a reset within the consumer time after the change, then Bdefault is still stored one consumer time later.
///
/// Verifies: ECSS 8.3.2a, 8.3.3l
#[test]
fn a_bus_found_before_a_reset_is_kept_after_it() {
    let (mut flight, _) = on_redundant(2000);
    assert_eq!(boots_on(&mut flight, false), Some(Bus::Redundant));
    flight.fly_to(5500);
    assert_eq!(boots_on(&mut flight, true), Some(Bus::Redundant), "{}", flight.log(SLAVE));
    flight.assert_sound();
}

/// Verifies: ECSS 8.3.2a, 8.3.3l
#[test]
fn load_clears_the_bus_that_was_kept() {
    for loses_power in [false, true] {
        let (mut flight, guest) = on_redundant(4000);
        write(&mut flight, guest, 0x1011, 1, b"load");
        assert_eq!(boots_on(&mut flight, loses_power), Some(Bus::Nominal), "{}", flight.log(SLAVE));
        // It follows its master, and finds the redundant bus again.
        flight.assert_operational([SLAVE], Bus::Redundant);
        assert_eq!(boots_on(&mut flight, false), Some(Bus::Redundant));
        flight.assert_sound();
    }
}

/// Verifies: ECSS 8.3.1c, 8.3.2a, 8.3.1a
#[test]
fn a_bdefault_written_is_gone_after_a_reset_unless_saved() {
    for (is_saved, expected) in [(false, Bus::Nominal), (true, Bus::Redundant)] {
        for loses_power in [false, true] {
            let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[..3], Bus::Nominal);
            flight.fly_to(1045);
            write(&mut flight, guest, 0x2000, 1, &[1]);
            if is_saved {
                write(&mut flight, guest, 0x1010, 1, b"save");
            }
            let bus = boots_on(&mut flight, loses_power);
            assert_eq!(bus, Some(expected), "saved: {is_saved}\n{}", flight.log(SLAVE));
            // The bus of its start does not matter. The master is on the nominal bus.
            flight.assert_operational([SLAVE], Bus::Nominal);
            flight.assert_sound();
        }
    }
}

/// Verifies: ECSS 8.3.2a
#[test]
fn the_master_starts_on_its_bdefault_whatever_bus_it_was_on() {
    let (mut flight, _) = on_redundant(4000);
    for loses_power in [false, true] {
        let from = flight.end;
        restart(&mut flight, MASTER, loses_power);
        flight.fly(flight.end + ms(50));
        let on = |bus| flight.attempts(MASTER, bus).filter(|at| *at > from).count() > 0;
        assert!(on(Bus::Nominal) && !on(Bus::Redundant), "its heartbeats go to the cut bus");
        let heard = flight.heartbeats(MASTER, Bus::Redundant).into_iter().filter(|(at, _)| *at > from);
        assert_eq!(heard.count(), 0);
    }
}
