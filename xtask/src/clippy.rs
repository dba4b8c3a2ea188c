//! `cargo xtask clippy`: lints boards and firmware for their target.

use ecss_can_cli::images::BoardCrate;
use ecss_can_cli::images::support::board::{Target, built_names};
use ecss_can_cli::images::support::misuse::Misuse;

/// Lints boards and firmware as they are compiled for a board of this project.
///
/// # Errors
/// When there is a warning, or the board is not one of this project.
pub fn run(target: &Target) -> anyhow::Result<()> {
    let BoardCrate::Shipped(name) = target.board.board_crate() else {
        let text = format!(
            "invalid value '{}' for '--board <BOARD>': the firmware of this project is linted for its own boards; allowed are {}",
            target.board.name(),
            built_names().join(", ")
        );
        return Err(Misuse::of("clippy", text).into());
    };
    Ok(ecss_can_cli::images::clippy(name, target.profile.name())?)
}
