//! The boards of a script: images, straps, positions on the cable.

use std::sync::{Arc, LazyLock, OnceLock};

use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::Crystal;
use can_twin::guest::Presence;
use can_twin::image::Image;
use can_twin::spacecraft::{GuestId, Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;
use ecss_can::types::{Bus, PerBus};

use super::there;
use crate::campaign::script::{SECOND_BOARD, SPACING, Script};
use crate::images::support::board::{Board, Profile};
use crate::images::support::fleet::{self, image};
use crate::images::support::node::{MASTER, SECOND_MASTER};

static BOARD: LazyLock<Board> = LazyLock::new(|| Board::shipped(Board::DEFAULT));
/// Greatest error of a crystal in parts per million.
const CRYSTAL_PPM: f64 = 50.0;
/// Boards get power within the first 50 ms.
const POWER_ON_WITHIN_US: u64 = 50_000;

/// Images of master and slave.
type Images = [Arc<Image>; 2];

static ONE_MASTER: OnceLock<Images> = OnceLock::new();
static TWO_MASTERS: OnceLock<Images> = OnceLock::new();

/// Returns the images for this number of masters, and their profile.
fn images(masters: u8) -> (&'static OnceLock<Images>, Profile) {
    if masters == 1 { (&ONE_MASTER, Profile::Standard) } else { (&TWO_MASTERS, Profile::Standby) }
}

/// Builds the images for scripts with this number of masters, or uses those that were built last.
///
/// # Errors
/// When they cannot be built or read, or with `build` false were not built before.
pub fn prepare(masters: u8, build: bool) -> anyhow::Result<()> {
    let (prepared, profile) = images(masters);
    let built = fleet::built(&BOARD, profile, !build)?;
    let images = [image(&built.master)?, image(&built.slave)?];
    prepared.get_or_init(|| images);
    Ok(())
}

/// Returns the spacecraft of a script, and an inactive guest of each bus. Node n is board n - 1, the second master
/// board is the last one.
///
/// # Panics
/// Without [`prepare`] for this number of masters before.
pub fn spacecraft(script: &Script) -> (Spacecraft, PerBus<GuestId>) {
    let [master, slave] = images(script.masters).0.get().expect("images of master and slave");
    let mut random = fastrand::Rng::with_seed(script.seed);
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let second = (script.masters == 2).then_some(SECOND_BOARD);
    for node in (1..=script.slaves + 1).chain(second) {
        let (name, image, board) = match node {
            1 => ("node 1".into(), master, MASTER),
            SECOND_BOARD => ("second master".into(), master, SECOND_MASTER),
            _ => (format!("node {node}"), slave, node),
        };
        spacecraft.add_board(BoardConfig {
            name,
            model: BOARD.model(),
            image: image.clone(),
            straps: BOARD.straps(board),
            crystal: Crystal::ppm((2.0 * random.f64() - 1.0) * CRYSTAL_PPM),
            position_m: f64::from(script.place(node)),
            power_on_at: Time::from_us(random.u64(0..POWER_ON_WITHIN_US)),
            fittings: Fittings::default(),
        });
    }
    let end_m = f64::from(SPACING * u32::from(script.slaves + 1 + script.masters));
    let guests = PerBus::from_fn(|bus| spacecraft.add_guest(there(bus), end_m));
    Bus::ALL.into_iter().for_each(|bus| spacecraft.set_presence(guests[bus], Presence::Away));
    (spacecraft, guests)
}
