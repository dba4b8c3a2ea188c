//! Boards of both models on the same two buses: a NUCLEO-F446RE commands another one and two pyboards.

use std::sync::LazyLock;

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use flight::*;

const CUT: Time = Time::from_ms(2013);

const SETUPS: [BoardSetup; 4] = [
    BoardSetup { board: NUCLEO_F446RE, ..MASTER_AND_THREE[0] },
    MASTER_AND_THREE[1],
    BoardSetup { board: NUCLEO_F446RE, ..MASTER_AND_THREE[2] },
    MASTER_AND_THREE[3],
];

/// A flight in which the nominal bus breaks next to the master, so that slave 4 must search for it.
static FLIGHT: LazyLock<Recording> = LazyLock::new(|| Flight::new(&SETUPS).cut_next_to_master(CUT, 15_500));

/// Given boards of both models, then their straps give their Node-IDs, and both boot on the default bus.
#[test]
fn boards_of_both_models_boot_and_are_started() {
    for setup in SETUPS {
        let heartbeats = FLIGHT.heartbeats(setup.node, Bus::Nominal);
        let states: Vec<u8> = heartbeats.iter().map(|(_, state)| *state).collect();
        assert_eq!(states[..2], [BOOT_UP, OPERATIONAL], "node {}", setup.node);
        assert!(heartbeats[1].0 < ms(300), "node {}: {} us", setup.node, heartbeats[1].0.as_us());
    }
}

#[test]
fn boards_of_both_models_follow_to_the_other_bus() {
    FLIGHT.assert_operational(SETUPS.map(|setup| setup.node), Bus::Redundant);
    // These have parallel access.
    FLIGHT.assert_kept_running([2, 3], ms(300));
    assert!(FLIGHT.fell_back(4, CUT), "node 4 has selective access");
}

#[test]
fn commands_reach_boards_of_both_models_on_both_buses() {
    for node in [2, 3] {
        for (bus, from) in [(Bus::Nominal, ms(500)), (Bus::Redundant, CUT + ms(500))] {
            assert_replies(&FLIGHT, node, bus, from, |_| true);
        }
    }
}

/// Given wrong parity on the pins of the F446, then the board is silent.
#[test]
fn an_f446_without_valid_straps_is_silent() {
    let mut flight = Flight::new(&[SETUPS[0], BoardSetup { parity: false, ..SETUPS[2] }]);
    flight.fly_to(300);
    flight.assert_said(3, "staying silent", ms(20));
    assert_eq!(flight.frames, [], "nobody acknowledges the master");
}
