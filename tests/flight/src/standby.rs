//! Two master boards: one is active, the other one is silent and takes over (profile `standby`: consumer time of the standby
//! 400 ms, of slaves 250 ms; a slave changes the bus after 500 ms).

use std::sync::LazyLock;

use can_twin::board::BoardConfig;
use can_twin::pin::Pin;
use can_twin::spacecraft::{BoardId, Bus};
use can_twin::wire::time::Time;

use crate::*;

/// The images.
pub static TWO_MASTERS: LazyLock<Images> = LazyLock::new(|| build("pyboard-v11", "standby"));

/// The board strapped prime.
pub const PRIME: u8 = MASTER;
/// Number of the second master board, which is node 1 too.
pub const SECOND: u8 = 128;
/// Position between the two master boards.
pub const BETWEEN_MASTERS_M: f64 = 2.0;

/// A pyboard.
pub const fn setup(node: u8, ppm: f64, position_m: f64, power_on_ms: u64) -> BoardSetup {
    BoardSetup { node, board: PYBOARD_V11, ppm, position_m, power_on_ms, parity: true }
}

/// All boards: prime at the left end, the slaves at the right end.
pub const ALL: [BoardSetup; 4] = [
    setup(PRIME, 12.0, 0.0, 20),
    setup(SECOND, -31.0, 4.0, 20),
    setup(2, 48.0, 11.5, 60),
    setup(3, -50.0, 23.0, 110),
];

/// Returns the configuration of a slave, or of a master board with its strap.
pub fn config(setup: BoardSetup) -> BoardConfig {
    let closed = |number| vec![(Pin::new('A', number), false)];
    match setup.node {
        PRIME => BoardConfig { straps: closed(2), ..setup.with(&TWO_MASTERS) },
        SECOND => {
            let image = TWO_MASTERS[0].clone();
            BoardConfig { name: "second".into(), image, straps: closed(6), ..setup.with(&TWO_MASTERS) }
        }
        _ => setup.with(&TWO_MASTERS),
    }
}

/// Boards with the images of profile `standby`.
pub fn flight(setups: &[BoardSetup]) -> Flight {
    Flight::of(setups, config)
}

/// Returns the heartbeats and boot-up messages of a master board: start, end and bus.
pub fn heartbeats(flight: &Recording, board: BoardId) -> Vec<(Time, Time, Bus)> {
    let all = flight.frames.iter().filter(|seen| seen.sender == board.0 && seen.id() == Some(0x701));
    all.map(|seen| (seen.start, seen.end, seen.bus)).collect()
}

/// Returns whether the last heartbeat of a master board is at most one period old.
pub fn is_active(flight: &Recording, board: BoardId) -> bool {
    heartbeats(flight, board).last().is_some_and(|(_, end, _)| flight.end.since(*end) < ms(110))
}
