//! `cargo xtask firmware`: both images, where they are and how big.

use clap::Args;

use support::board::{Board, Profile};
use support::elf::{Facts, Size};
use support::output;

/// Command line of `firmware`.
#[derive(Args, Debug)]
pub struct Options {
    /// Board to build for
    #[arg(long, value_name = "BOARD", value_enum, default_value_t = Board::PyboardV11)]
    board: Board,

    /// Mission profile to build with
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    profile: Profile,
}

/// Builds both images, prints paths and sizes.
///
/// # Errors
/// When an image cannot be built or read.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let images = firmware_images::build(options.board.name(), options.profile.name())?;
    for (role, path) in [("master", &images.master), ("slave", &images.slave)] {
        let Size { flash, ram } = Facts::read(path)?.size;
        output::line(format_args!(
            "{role:<6}  {flash:>7} bytes of flash  {ram:>6} bytes of static RAM  {}",
            path.display()
        ))?;
    }
    Ok(())
}

/// Lints boards and firmware as they are compiled for a board.
///
/// # Errors
/// When there is a warning.
pub fn clippy(options: &Options) -> anyhow::Result<()> {
    Ok(firmware_images::clippy(options.board.name(), options.profile.name())?)
}
