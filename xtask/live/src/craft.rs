//! The boards of `cargo twin`: those of `cargo demo`, by another command line.

use demo::plan;
use support::craft::{Images, MASTER};
use twin::spacecraft::{Spacecraft, SpacecraftConfig};

use super::Options;

/// Puts boards without power on two wires; they get it within the first 0.3 s.
pub fn assemble(options: &Options, images: &Images) -> Spacecraft {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for board in plan::boards(plan::SEED, &options.nodes()) {
        let name = if board.node == MASTER { "master".into() } else { format!("slave {}", board.node) };
        spacecraft.add_board(board.config(options.craft.board, name, images[&board.node].clone()));
    }
    spacecraft
}
