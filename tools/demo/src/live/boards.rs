//! The boards of `cargo twin`: those of `cargo demo`, by another command line.

use std::collections::BTreeMap;

use crate::plan;
use firmware_images::support::fleet::Images;
use firmware_images::support::misuse::Misuse;
use firmware_images::support::node::{MASTER, Node, SECOND_MASTER};
use twin::board::BoardConfig;
use twin::spacecraft::{BoardId, Spacecraft, SpacecraftConfig};

use super::Options;

/// The boards by their nodes. They get power within the first 0.3 s.
///
/// # Errors
/// When a board cannot have the part that was given.
pub fn boards(options: &Options, images: &Images) -> Result<BTreeMap<Node, BoardConfig>, Misuse> {
    let plans = plan::boards(crate::SEED, &options.nodes()).into_iter();
    let fleet = &options.fleet;
    let own = fleet.own_board("twin")?;
    let boards = plans
        .map(|board| {
            let name = match board.node {
                MASTER => "master".into(),
                SECOND_MASTER => "second master".into(),
                slave => format!("slave {slave}"),
            };
            let model = if fleet.own_image(board.node).is_some() { &own } else { &fleet.target.board };
            (board.node, board.config(model, name, images[&board.node].clone()))
        })
        .collect();
    Ok(boards)
}

/// Puts boards without power on two wires.
pub fn assemble(boards: BTreeMap<Node, BoardConfig>) -> (Spacecraft, BTreeMap<Node, BoardId>) {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let boards = boards.into_iter().map(|(node, config)| (node, spacecraft.add_board(config))).collect();
    (spacecraft, boards)
}
