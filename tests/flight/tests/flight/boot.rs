//! The slave image alone on a board: it loads, runs and logs.

use can_twin::board::{BoardConfig, State};
use can_twin::pin::Pin;
use can_twin::rtt::Level;
use can_twin::spacecraft::{Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;
use flight::{PYBOARD_V11, bare, parsed};

/// Verifies: ECSS 6.10e
#[test]
fn the_slave_image_boots_and_logs() {
    let images = ecss_can_cli::images::build("pyboard-v11", "librecube").unwrap();
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let id = spacecraft.add_board(BoardConfig {
        // Node-ID 2 and odd parity: bit 1 closed to ground, nothing else.
        straps: vec![(Pin::new('A', 3), false)],
        power_on_at: Time::from_ms(10),
        ..bare(PYBOARD_V11, parsed(&images.slave))
    });
    spacecraft.run_until(Time::from_ms(200)).unwrap();

    let board = spacecraft.board(id);
    assert_eq!(*board.state(), State::Running);
    assert_eq!(board.hclk(), 168_000_000);
    let counters = board.counters();
    assert_eq!((counters.panics, counters.lockups, counters.malformed_logs), (0, 0, 0));

    let control_block = board.symbol("_SEGGER_RTT").unwrap();
    assert_eq!(board.read_memory(control_block.address, 10).unwrap(), b"SEGGER RTT");

    let logs = spacecraft.take_logs();
    let start = logs.first().expect("a slave says that it starts");
    assert_eq!((start.board, start.level), (id, Some(Level::Info)));
    assert!(start.at > Time::from_ms(10), "not before it has power");
    assert!(start.text.contains("slave 2"), "{}", start.text);
}
