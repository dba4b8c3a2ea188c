//! The boards of `cargo twin`: those of `cargo demo`, by another command line.

use std::collections::BTreeMap;

use demo::plan;
use support::craft::{Images, MASTER, Node, SECOND_MASTER};
use twin::board::BoardConfig;
use twin::spacecraft::{BoardId, Spacecraft, SpacecraftConfig};

use super::Options;

/// The boards by their nodes. They get power within the first 0.3 s.
pub fn boards(options: &Options, images: &Images) -> BTreeMap<Node, BoardConfig> {
    let plans = plan::boards(plan::SEED, &options.nodes()).into_iter();
    plans
        .map(|board| {
            let name = match board.node {
                MASTER => "master".into(),
                SECOND_MASTER => "second master".into(),
                slave => format!("slave {slave}"),
            };
            (board.node, board.config(options.craft.target.board, name, images[&board.node].clone()))
        })
        .collect()
}

/// Puts boards without power on two wires.
pub fn assemble(boards: BTreeMap<Node, BoardConfig>) -> (Spacecraft, BTreeMap<Node, BoardId>) {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let boards = boards.into_iter().map(|(node, config)| (node, spacecraft.add_board(config))).collect();
    (spacecraft, boards)
}
