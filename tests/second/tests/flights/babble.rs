//! A node that keeps sending reset commands.

use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// The consumer time.
const CONSUMER_MS: u64 = 2500;

/// Lets a guest on the nominal bus send this command to all nodes every 20 ms.
fn babble(flight: &mut Flight, command: u8, from_ms: u64, until_ms: u64) {
    let guest = flight.twin.add_guest(Bus::Nominal, 30.0);
    for at in (from_ms..until_ms).step_by(20) {
        flight.twin.inject(guest, ms(at), WireFrame::standard(0x000, &[command, 0]));
    }
}

/// Returns the times of boot-up messages of `node` after `from`, on either bus.
fn boot_ups(flight: &Flight, node: u8, from: Time) -> Vec<Time> {
    let all = Bus::ALL.into_iter().flat_map(|bus| flight.heartbeats(node, bus));
    let mut all: Vec<_> =
        all.filter(|(at, state)| *at > from && *state == BOOT_UP).map(|(at, _)| at).collect();
    all.sort_unstable();
    all
}

/// Returns the sources of emergencies 8100h of `node` on either bus after `from`.
fn refusals(flight: &Flight, node: u8, from: Time) -> Vec<u8> {
    flight.emergencies(node, from).filter(|data| data[..2] == [0x00, 0x81]).map(|data| data[3]).collect()
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5, 8.3.3e, 8.3.3g
#[test]
fn slaves_leave_a_bus_on_which_resets_are_babbled() {
    for command in [0x81, 0x82] {
        println!("{command:02X}h");
        let mut flight = Flight::new(&MASTER_AND_THREE);
        babble(&mut flight, command, 1000, 19_000);
        flight.fly_to(1000);
        // The master goes to the redundant bus. The babbling node and the slaves stay on the nominal one.
        flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
        flight.fly_to(3000);
        flight.assert_operational([2, 3], Bus::Redundant);
        // Selective access: it searches for Ttoggle (5) consumer times before it tries the other bus.
        flight.fly_to(1000 + 5 * CONSUMER_MS + 2000);
        flight.assert_operational([2, 3, 4], Bus::Redundant);
        for node in [2, 3, 4] {
            // The first reset follows a heartbeat of the master. Those with parallel access hear the next one soon.
            let booted = boot_ups(&flight, node, ms(1000)).len();
            let most = 1 + 3;
            assert!((1..=most).contains(&booted), "{command:02X}h {node}\n{}", flight.log(node));
            if node == 4 {
                assert_eq!(booted, most, "{command:02X}h\n{}", flight.log(node));
                // Once on the bus with the resets, and once to the master that it finds on the other one.
                let refused = refusals(&flight, node, ms(1000));
                assert_eq!(refused, [command; 2], "{command:02X}h\n{}", flight.log(node));
            }
        }
        // The slaves stay there for the whole fault.
        flight.fly_to(19_000);
        flight.assert_operational([2, 3, 4], Bus::Redundant);
        for node in [2_u8, 3, 4] {
            let commands = flight.sent(MASTER, Bus::Redundant, 0x300 + u16::from(node));
            assert!(commands.filter(|seen| seen.end > ms(17_000)).count() >= 19, "node {node}");
        }
        flight.assert_sound();
    }
}

/// Given no master since the boot, when each reset comes after a pause of two consumer times, then it is obeyed.
///
/// Verifies: ECSS 6.5.1a.4
#[test]
fn every_reset_after_a_pause_is_obeyed_without_a_master() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[1..2], Bus::Nominal);
    flight.fly_to(1000);
    // The pause counts from the boot, some milliseconds after the reset.
    let period = 2 * CONSUMER_MS + 20;
    for number in 0..20 {
        flight.twin.inject(guest, ms(6000 + number * period), WireFrame::standard(0x000, &[0x81, 2]));
    }
    flight.fly_to(6000 + 20 * period);
    let booted = boot_ups(&flight, 2, ms(1000));
    assert_eq!(booted.len(), 20, "{}", flight.log(2));
    assert!(refusals(&flight, 2, Time::ZERO).is_empty());
    flight.assert_sound();
}

/// Given resets in a row, when the fourth is ignored, then resets are obeyed again after a heartbeat of the master.
///
/// Verifies: ECSS 6.5.1a.4
#[test]
fn a_heartbeat_of_the_master_makes_resets_count_again() {
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE[1..2], Bus::Nominal);
    let reset = WireFrame::standard(0x000, &[0x81, 2]);
    for at in [500, 600, 700, 800, 900, 1300] {
        flight.twin.inject(guest, ms(at), reset);
        if at == 900 {
            flight.twin.inject(guest, ms(1000), WireFrame::standard(0x701, &[OPERATIONAL]));
        }
    }
    flight.fly_to(1290);
    let booted = boot_ups(&flight, 2, ms(500));
    assert_eq!(booted.len(), 3, "{booted:?}\n{}", flight.log(2));
    // Once, not per frame, and once more to the master that it finds.
    assert_eq!(refusals(&flight, 2, Time::ZERO), [0x81; 2]);
    // Error reset.
    let gone = flight.first_after(ms(1000), |seen| seen.id() == Some(0x082) && seen.data()[..2] == [0, 0]);
    assert_eq!(gone.unwrap().data()[3..6], [0x00, 0x81, 0x81]);
    flight.fly_to(1700);
    assert_eq!(boot_ups(&flight, 2, ms(1290)).len(), 1, "{}", flight.log(2));
    flight.assert_sound();
}
