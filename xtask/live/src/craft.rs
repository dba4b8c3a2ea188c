//! The boards of `cargo twin`: those of `cargo demo`, by another command line.

use std::collections::BTreeMap;

use demo::plan;
use support::craft::{Images, MASTER, Node, SECOND_MASTER};
use twin::spacecraft::{BoardId, Spacecraft, SpacecraftConfig};

use super::Options;

/// Puts boards without power on two wires; they get it within the first 0.3 s.
pub fn assemble(options: &Options, images: &Images) -> (Spacecraft, BTreeMap<Node, BoardId>) {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let mut boards = BTreeMap::new();
    for board in plan::boards(plan::SEED, &options.nodes()) {
        let name = match board.node {
            MASTER => "master".into(),
            SECOND_MASTER => "second master".into(),
            slave => format!("slave {slave}"),
        };
        let config = board.config(options.craft.board, name, images[&board.node].clone());
        boards.insert(board.node, spacecraft.add_board(config));
    }
    (spacecraft, boards)
}
