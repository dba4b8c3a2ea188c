//! `cargo xtask firmware`: both images, where they are and how big.

use clap::Args;

use crate::board::Board;

/// Command line of `firmware`.
#[derive(Args, Debug)]
pub struct Options {
    /// Board to build for
    #[arg(long, value_name = "BOARD", value_enum, default_value_t = Board::PyboardV11)]
    board: Board,
}

/// Builds and prints.
pub fn run(options: &Options) -> anyhow::Result<()> {
    anyhow::bail!("not yet {options:?}")
}
