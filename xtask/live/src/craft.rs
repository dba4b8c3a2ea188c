//! The boards of `cargo twin`: those of `cargo demo`, by another command line, and boards with images of the user.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use demo::mission::image;
use demo::plan::Plan;
use demo::record::{MASTER, Node};
use support::misuse::Misuse;
use twin::board::{BoardConfig, Fittings};
use twin::image::Image;
use twin::spacecraft::{Spacecraft, SpacecraftConfig};

use super::Options;

/// An image for each node.
pub type Images = BTreeMap<Node, Arc<Image>>;

/// Reads the images of the user.
///
/// # Errors
/// [`Misuse`] when one cannot be read or is no image.
pub fn own_images(options: &Options) -> Result<Images, Misuse> {
    let read = |path: &Path| image(path).map_err(|error| Misuse::of("twin", format!("{error:#}")));
    let own = options.nodes().into_iter().filter_map(|node| Some((node, options.own_image(node)?)));
    own.map(|(node, path)| Ok((node, read(path)?))).collect()
}

/// Builds what the user has not given. Nothing is built when no board needs it.
///
/// # Errors
/// When an image cannot be built or read.
pub fn add_shipped(options: &Options, images: &mut Images) -> anyhow::Result<()> {
    let missing: Vec<Node> = options.nodes().into_iter().filter(|node| !images.contains_key(node)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let built = firmware_images::build(options.board.name(), options.profile.name())?;
    let (master, slave) = (image(&built.master)?, image(&built.slave)?);
    images.extend(
        missing.into_iter().map(|node| (node, if node == MASTER { &master } else { &slave }.clone())),
    );
    Ok(())
}

/// Boards without power on two wires; they get it within the first 0.3 s.
///
/// # Errors
/// Never with the plan of a demo without a cut.
pub fn assemble(options: &Options, images: &Images) -> anyhow::Result<Spacecraft> {
    let last = images.keys().max().copied().unwrap_or(MASTER);
    let demo = demo::Options { slaves: last - MASTER, board: options.board, ..demo::Options::default() };
    let plan = Plan::new(&demo)?;
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for board in &plan.boards {
        let Some(image) = images.get(&board.node) else { continue };
        spacecraft.add_board(BoardConfig {
            name: if board.node == MASTER { "master".into() } else { format!("slave {}", board.node) },
            model: options.board.model(),
            image: image.clone(),
            straps: options.board.straps(board.node),
            ppm: board.crystal_ppm,
            position_m: board.position_m,
            power_on_at: board.power_on,
            fittings: Fittings::default(),
        });
    }
    Ok(spacecraft)
}
