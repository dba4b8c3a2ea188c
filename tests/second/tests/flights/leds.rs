//! LEDs (docs/wiring.md) and statistics of slaves for heartbeats of the master, SYNC and the spacecraft time.

use can_twin::pin::Pin;
use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use flight::*;
use flight::{minimal, standby};

/// Heartbeat, SYNC and spacecraft time of the master.
const HEARD: [u16; 3] = [0x701, 0x080, 0x181];

/// A full slave on a NUCLEO and a minimal one on a pyboard, profile `librecube`.
const SETUPS: [BoardSetup; 3] =
    [MASTER_AND_THREE[0], BoardSetup { board: NUCLEO_F446RE, ..MASTER_AND_THREE[1] }, minimal::SETUP];

#[test]
fn leds_toggle_with_what_a_slave_hears() {
    let mut flight = minimal::librecube(&SETUPS);
    flight.fly_to(21_500);
    for (setup, sync) in [(SETUPS[1], Pin::new('A', 5)), (SETUPS[2], Pin::new('B', 4))] {
        let heard =
            HEARD.map(|id| flight.with_id(id).filter(|seen| seen.reached.contains(&setup.node)).count());
        let changes = flight.emulated_mut(setup.node).take_pin_changes();
        let toggled = [Pin::new('B', 14), sync, Pin::new('B', 15)]
            .map(|led| changes.iter().filter(|change| change.pin == led).count());
        assert_eq!(toggled, heard, "node {}", setup.node);
        assert!(heard[0] > 15 && heard[1] > 1 && heard[2] > 1, "{heard:?}");
    }
}

/// Returns the numbers in a line.
fn numbers(line: &str) -> Vec<usize> {
    line.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse().ok()).collect()
}

/// Given a SYNC every 100 ms and 50 commands a second, then each board logs its statistics with every hundredth SYNC,
/// and they equal the frames on the bus until then.
#[test]
fn statistics_in_the_log_are_what_the_bus_carried() {
    let mut flight = minimal::standard(&[MASTER_AND_THREE[0], MASTER_AND_THREE[1], minimal::SETUP]);
    flight.fly_to(11_500);
    let line = |node, begin: &str| {
        let line = flight.logs.iter().find(|log| log.board == flight.board(node) && log.text.contains(begin));
        line.unwrap_or_else(|| panic!("nothing of {begin:?} but: {}", flight.log(node)))
    };
    let carried = |at: Time, id: u16, node| {
        flight.with_id(id).filter(|seen| seen.end <= at && seen.reached.contains(&node)).count()
    };
    for node in [2, minimal::SETUP.node] {
        let (line, id) = (line(node, "heard 100 heartbeats"), u16::from(node));
        let found = numbers(&line.text[line.text.find("heard").unwrap()..]);
        // A minimal slave takes no time in profile standard.
        let times = if node == 2 { carried(line.at, 0x181, node) } else { 0 };
        let heard = [carried(line.at, 0x701, node), carried(line.at, 0x080, node), times];
        assert_eq!(found[..3], heard, "node {node}: {}", line.text);
        let (commands, answers) = (carried(line.at, 0x300 + id, node), carried(line.at, 0x380 + id, 1));
        assert_eq!((found[3] + found[4], found[5]), (commands, answers), "node {node}: {}", line.text);
        assert!(commands > 50 && answers > 20, "{}", line.text);
    }
    let line = line(1, "sent 100 SYNC");
    let found = numbers(&line.text[line.text.find("sent").unwrap()..]);
    let sent = [(0x080, 2), (0x302, 2), (0x305, 5), (0x402, 2), (0x405, 5)]
        .map(|(id, node)| carried(line.at, id, node));
    // One of each may be in transmission.
    assert!(found[0] == sent[0], "{} {sent:?}", line.text);
    assert!((0..=2).contains(&(found[1] - sent[1] - sent[2])), "{} {sent:?}", line.text);
    assert!((0..=2).contains(&(found[2] - sent[3] - sent[4])), "{} {sent:?}", line.text);
}

/// Given a nominal bus that is cut beside the active master, when that board then loses its power, then the yellow LED of the other
/// one is lit: it is active on the redundant bus.
#[test]
fn yellow_led_shows_the_bus_of_a_takeover() {
    let mut flight = standby::flight(&standby::ALL);
    flight.fly_to(2_000);
    flight.twin.wire_mut(Bus::Nominal).cut(1.0);
    flight.fly_to(4_000);
    flight.twin.power(flight.board(standby::PRIME), false);
    flight.fly_to(5_000);
    flight.assert_said(standby::SECOND, "Active on Redundant (MasterSilent)", ms(4_000));
    let changes = flight.emulated_mut(standby::SECOND).take_pin_changes();
    let yellow = changes.iter().rfind(|change| change.pin == Pin::new('A', 15));
    assert!(yellow.is_some_and(|change| change.high), "{yellow:?}");
}
