//! `cargo xtask firmware`: paths and sizes of the three images, or of those of a user's package.

use std::path::{Path, PathBuf};

use clap::Args;
use ecss_can_cli::images::support::board::{BitRate, Board, Profile, Target, built_names, help};
use ecss_can_cli::images::support::elf::{Facts, Size};
use ecss_can_cli::images::support::fleet;
use ecss_can_cli::images::support::misuse::Misuse;
use ecss_can_cli::images::support::output;
use ecss_can_cli::images::support::project::manifest;
use ecss_can_cli::images::{BoardCrate, Choice, Error, Package};

/// The subcommand.
const FIRMWARE: &str = "firmware";

/// Command line of `firmware`.
#[derive(Args, Debug)]
pub struct Options {
    /// Board to build for; `None`: the usual one, or that of the package.
    #[arg(long, value_name = "BOARD", value_parser = Board::parse, help = of_board())]
    board: Option<Board>,

    /// Mission profile to build with; standby: two master boards
    #[arg(long, value_name = "PROFILE", value_enum, default_value_t = Profile::Librecube)]
    profile: Profile,

    /// The minimal slave has one CAN controller and two transceivers (ECSS Figure A-6)
    #[arg(long)]
    one_controller: bool,

    /// Bit rate of both buses in kbit/s
    #[arg(long, value_name = "KBIT", value_enum, default_value_t = BitRate::Kbit1000)]
    bit_rate: BitRate,

    /// Firmware of your own: a package whose Cargo.toml has its board as the dependency `board`, or a feature for each of its boards
    #[arg(long, value_name = "NAME", conflicts_with_all = ["profile", "bit_rate", "one_controller"])]
    package: Option<String>,

    /// Cargo.toml of that package or of its workspace [default: the one of the current directory]
    #[arg(long, value_name = "FILE", requires = "package")]
    manifest_path: Option<PathBuf>,
}

/// Returns the help of `--board`.
fn of_board() -> String {
    let default = Board::DEFAULT;
    format!("{} [default: {default}; with --package the board in its Cargo.toml, if that names one]", help())
}

/// Builds the images, prints paths and sizes.
///
/// # Errors
/// When an image cannot be built or read, or does not start.
pub fn run(options: &Options) -> anyhow::Result<()> {
    if let Some(name) = &options.package {
        return own(name, options);
    }
    let board = options.board.clone().unwrap_or_else(|| Board::shipped(Board::DEFAULT));
    board.check_images(FIRMWARE)?;
    let profile = options.bit_rate.configuration(options.profile);
    let images = ecss_can_cli::images::build(board.board_crate(), &profile)?;
    let fitting = if options.one_controller { "+one-controller" } else { "" };
    let minimal = ecss_can_cli::images::build_minimal(
        board.board_crate(),
        &(profile + fitting),
        ecss_can_cli::images::LOG,
    )?;
    [("master", &images.master), ("slave", &images.slave), ("minimal", &minimal)]
        .into_iter()
        .try_for_each(|(role, path)| describe(role, path))
}

/// Builds the package `name` of the user.
fn own(name: &str, options: &Options) -> anyhow::Result<()> {
    let manifest = manifest(options.manifest_path.as_deref())?;
    let package = Package { name: name.to_owned(), manifest };
    let choice = package.choice().map_err(|error| match error {
        Error::NoPackage { .. } => anyhow::Error::from(Misuse::of(
            FIRMWARE,
            format!("invalid value '{name}' for '--package <NAME>': {error}"),
        )),
        error => error.into(),
    })?;
    let images = package.build(feature(name, &choice, options.board.as_ref())?)?;
    anyhow::ensure!(!images.is_empty(), "{name} has no program: it needs a src/main.rs");
    images.iter().try_for_each(|path| {
        let role = path.file_name().unwrap_or_default().to_string_lossy();
        describe(&role, path)
    })
}

/// Returns the feature of a package that selects the board of `--board`, or the default one. `None`: its manifest names
/// the board.
fn feature<'a>(name: &str, choice: &Choice, board: Option<&'a Board>) -> Result<Option<&'a str>, Misuse> {
    let has = |feature: &str| choice.features.iter().any(|known| known == feature);
    match board.map(Board::name) {
        None => Ok((!choice.is_fixed && has(Board::DEFAULT)).then_some(Board::DEFAULT)),
        Some(board) if has(board) => Ok(Some(board)),
        Some(board) => {
            let boards: Vec<_> = built_names().into_iter().filter(|board| has(board)).collect();
            let rest = if boards.is_empty() {
                "it chooses its board in Cargo.toml: leave out --board".to_owned()
            } else {
                format!("allowed are {}", boards.join(", "))
            };
            let text = format!(
                "invalid value '{board}' for '--board <BOARD>': the package {name} has no dependency {board}; {rest}"
            );
            Err(Misuse::of(FIRMWARE, text))
        }
    }
}

fn describe(role: &str, path: &Path) -> anyhow::Result<()> {
    fleet::image(path)?;
    let Size { flash, ram } = Facts::read(path)?.size;
    output::line(format_args!(
        "{role:<7}  {flash:>7} bytes of flash  {ram:>6} bytes of static RAM  {}",
        path.display()
    ))
}

/// Lints boards and firmware as they are compiled for a board of this project.
///
/// # Errors
/// When there is a warning, or the board is not one of this project.
pub fn clippy(target: &Target) -> anyhow::Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(is_fixed: bool, features: &[&str]) -> Choice {
        Choice { is_fixed, features: features.iter().map(|&name| name.to_owned()).collect() }
    }

    #[test]
    fn package_is_built_for_the_board_of_manifest_or_feature() {
        let nucleo = Board::shipped("nucleo-f446re");
        let both = ["nucleo-f446re", "pyboard-v11"];
        for (is_fixed, features, board, expected) in [
            (true, &[][..], None, None),
            (true, &["pyboard-v11"], None, None),
            (false, &["fast"], None, None),
            (false, &both, None, Some("pyboard-v11")),
            (false, &both, Some(&nucleo), Some("nucleo-f446re")),
        ] {
            assert_eq!(
                feature("heater", &choice(is_fixed, features), board),
                Ok(expected),
                "{features:?} {board:?}"
            );
        }
        let error =
            feature("heater", &choice(false, &["pyboard-v11"]), Some(&nucleo)).unwrap_err().to_string();
        assert!(error.ends_with("has no dependency nucleo-f446re; allowed are pyboard-v11"), "{error}");
    }
}
