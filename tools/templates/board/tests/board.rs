//! The description of the board, as the emulator reads it.

use std::path::Path;

use can_twin::description::Description;

/// Given `board.toml`, then its chip can be emulated and has its pins, and no pin has two functions.
#[test]
fn description_is_one_of_a_board_that_can_be_emulated() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let board = Description::read(folder).unwrap_or_else(|wrong| panic!("{wrong}"));
    assert_eq!(board.name, env!("CARGO_PKG_NAME"));
}
