//! The boards of `cargo twin`: those of `cargo demo`, by another command line.

use firmware_images::Images;
use twin::board::{BoardConfig, Fittings};
use twin::spacecraft::{Spacecraft, SpacecraftConfig};

use super::Options;
use demo::mission::image;
use demo::plan::Plan;
use demo::record::MASTER;

/// Boards without power on two wires; they get it within the first 0.3 s.
///
/// # Errors
/// When an image cannot be read or is not one.
pub fn assemble(options: &Options, images: &Images) -> anyhow::Result<Spacecraft> {
    let demo = demo::Options { slaves: options.slaves, board: options.board, ..demo::Options::default() };
    let plan = Plan::new(&demo)?;
    let (master, slave) = (image(&images.master)?, image(&images.slave)?);
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for board in plan.boards.iter().filter(|board| board.node != MASTER || !options.no_master) {
        spacecraft.add_board(BoardConfig {
            name: if board.node == MASTER { "master".into() } else { format!("slave {}", board.node) },
            model: options.board.model(),
            image: if board.node == MASTER { &master } else { &slave }.clone(),
            straps: options.board.straps(board.node),
            ppm: board.crystal_ppm,
            position_m: board.position_m,
            power_on_at: board.power_on,
            fittings: Fittings::default(),
        });
    }
    Ok(spacecraft)
}
