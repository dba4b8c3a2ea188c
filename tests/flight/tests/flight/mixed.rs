//! Boards of both models on the same two buses: a NUCLEO-F446RE commands another one and two pyboards.

use std::sync::LazyLock;

use can_wire::time::Time;
use twin::spacecraft::Bus;

use flight::*;

const CUT: Time = Time::from_ms(2013);

const SEATS: [Seat; 4] = [
    Seat { board: NUCLEO_F446RE, ..MASTER_AND_THREE[0] },
    MASTER_AND_THREE[1],
    Seat { board: NUCLEO_F446RE, ..MASTER_AND_THREE[2] },
    MASTER_AND_THREE[3],
];

/// The nominal bus breaks next to the master; slave 4 has to search for it.
static FLIGHT: LazyLock<Recording> = LazyLock::new(|| {
    let mut craft = Craft::new(&SEATS);
    craft.fly(CUT);
    craft.twin.wire_mut(Bus::Nominal).cut(NEXT_TO_MASTER_M);
    craft.fly_to(15_500);
    craft.assert_nothing_lost();
    craft.seen
});

/// The straps of both models number their slaves, and both boot on the default bus.
#[test]
fn boards_of_both_models_boot_and_are_started() {
    for seat in SEATS {
        let heartbeats = FLIGHT.heartbeats(seat.node, Bus::Nominal);
        let states: Vec<u8> = heartbeats.iter().map(|(_, state)| *state).collect();
        assert_eq!(states[..2], [BOOT_UP, OPERATIONAL], "node {}", seat.node);
        assert!(heartbeats[1].0 < ms(300), "node {}: {} us", seat.node, heartbeats[1].0.as_us());
    }
}

#[test]
fn boards_of_both_models_follow_to_the_other_bus() {
    for seat in SEATS {
        assert!(FLIGHT.is_operational(seat.node, Bus::Redundant), "{}", FLIGHT.log(seat.node));
    }
    for node in [2, 3] {
        assert!(!FLIGHT.fell_back(node, ms(300)), "node {node} has parallel access");
    }
    assert!(FLIGHT.fell_back(4, CUT), "node 4 has selective access");
}

#[test]
fn commands_reach_boards_of_both_models_on_both_buses() {
    for node in [2_u8, 3] {
        for (bus, from) in [(Bus::Nominal, ms(500)), (Bus::Redundant, CUT + ms(500))] {
            let request =
                FLIGHT.first_after(from, |seen| seen.id() == Some(0x400 + u16::from(node))).unwrap();
            let reply =
                FLIGHT.first_after(request.end, |seen| seen.id() == Some(0x380 + u16::from(node))).unwrap();
            assert_eq!((request.bus, reply.bus), (bus, bus), "node {node}");
            assert!(reply.end < request.end + ms(2), "node {node} at {} us", request.end.as_us());
        }
    }
}

/// Wrong parity on the F446's own pins.
#[test]
fn an_f446_without_valid_straps_is_silent() {
    let mut craft = Craft::new(&[SEATS[0], Seat { parity: false, ..SEATS[2] }]);
    craft.fly_to(300);
    assert!(craft.said(3, "staying silent", ms(20)).is_some(), "{}", craft.log(3));
    assert_eq!(craft.frames, [], "nobody acknowledges the master");
}
