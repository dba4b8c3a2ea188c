//! The nominal bus is cut next to the master before any node hears it, so it must find its slaves on the other bus.
//!
//! Profile `standard`: a dwell is 10 s. Profile `librecube`: twice Ttoggle consumer times and two heartbeats, 25.5 s.

use can_twin::spacecraft::Bus;
use flight::*;

/// Returns the master and slaves 2, 3, … The master is powered `power_on_ms` after the slaves' zero.
fn late_master(count: usize, power_on_ms: u64) -> Vec<BoardSetup> {
    let mut setups = MASTER_AND_THREE[..=count].to_vec();
    setups[0].power_on_ms = power_on_ms;
    setups
}

/// Given slaves that gave up after 51 times 500 ms, then the master alternates buses, and they hear it on the other
/// one.
#[test]
fn a_late_master_on_a_cut_bus_finds_slaves_that_gave_up() {
    let mut flight = Flight::with(&late_master(2, 26_000), &STANDARD);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(35_990);
    for node in [2, 3] {
        flight.assert_said(node, "given up", ms(25_000));
    }
    assert!(!flight.of(MASTER).any(|seen| seen.bus == Bus::Redundant), "it begins with Bdefault, for 10 s");
    flight.fly_to(36_200);
    flight.assert_operational([2, 3], Bus::Redundant);
    flight.fly_to(38_000);
    flight.assert_operational([2, 3], Bus::Redundant);
    flight.assert_nothing_lost();
}

/// Given a guest on the master's side of the cut that acknowledges all frames and sends none, then the master does not
/// stay on that bus.
#[test]
fn a_guest_that_only_acknowledges_keeps_no_master_on_a_dead_bus() {
    let mut flight = Flight::with(&late_master(2, 5_600), &STANDARD);
    let guest = flight.twin.add_guest(Bus::Nominal, 0.2);
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(15_590);
    let acknowledged = flight.heartbeats(MASTER, Bus::Nominal).len();
    assert!((99..=102).contains(&acknowledged), "{acknowledged} heartbeats were acknowledged");
    assert!(flight.said(1, "error Passive", ms(5_600)).is_none(), "{}", flight.log(1));
    flight.fly_to(15_800);
    flight.assert_operational([2, 3], Bus::Redundant);
    assert!(flight.frames.iter().all(|seen| seen.bus == Bus::Redundant || seen.sender != guest.node));
    flight.assert_nothing_lost();
}

/// Given slaves that stay on their buses after 137.5 s, then all are found except slave 4 with selective access, which
/// ECSS 8.3.3j keeps on the cut bus. Its master reports that it is not heard.
///
/// Verifies: ECSS 8.3.3j
#[test]
fn librecube_slaves_that_gave_up_are_found_but_a_selective_one() {
    let mut flight = Flight::new(&late_master(3, 138_500));
    flight.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    flight.fly_to(163_900);
    for node in [2, 3, 4] {
        flight.assert_said(node, "given up", ms(137_000));
    }
    assert!(!flight.of(MASTER).any(|seen| seen.bus == Bus::Redundant), "it begins with Bdefault, for 25.5 s");
    flight.fly_to(164_400);
    flight.assert_operational([2, 3], Bus::Redundant);
    flight.fly_to(138_500 + 2 * 25_500 + 500);
    flight.assert_operational([2, 3], Bus::Redundant);
    flight.assert_said(1, "slave 4: never heard", ms(138_500));
    assert!(flight.said(1, "slave 2: never heard", ms(138_500)).is_none(), "{}", flight.log(1));
    let of_four = flight.on(Bus::Redundant).filter(|seen| seen.sender == 3 && seen.end > ms(137_700));
    assert_eq!(of_four.count(), 0, "slave 4 stays where it gave up");
    flight.assert_nothing_lost();
}
