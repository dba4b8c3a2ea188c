//! `cargo xtask firmware`: the three images, or those of a package of yours, where they are and how big.

use std::path::{Path, PathBuf};

use clap::Args;
use firmware_images::Package;

use support::board::{BitRate, Target};
use support::elf::{Facts, Size};
use support::output;
use support::project::manifest;

/// Command line of `firmware`.
#[derive(Args, Debug)]
pub struct Options {
    /// Board and profile.
    #[command(flatten)]
    target: Target,

    /// The minimal slave has one CAN controller and two transceivers (ECSS Figure A-6)
    #[arg(long)]
    one_controller: bool,

    /// Bit rate of both buses in kbit/s
    #[arg(long, value_name = "KBIT", value_enum, default_value_t = BitRate::Kbit1000)]
    bit_rate: BitRate,

    /// Firmware of your own: a package with a feature for each of its boards
    #[arg(long, value_name = "NAME", conflicts_with_all = ["profile", "bit_rate", "one_controller"])]
    package: Option<String>,

    /// Cargo.toml of that package or of its workspace [default: the one of the current directory]
    #[arg(long, value_name = "FILE", requires = "package")]
    manifest_path: Option<PathBuf>,
}

/// Builds the images, prints paths and sizes.
///
/// # Errors
/// When an image cannot be built or read.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let Target { board: described, profile } = &options.target;
    let board = described.name();
    let Some(name) = &options.package else {
        described.check_images("firmware")?;
        let profile = options.bit_rate.configuration(*profile);
        let images = firmware_images::build(board, &profile)?;
        let fitting = if options.one_controller { "+one-controller" } else { "" };
        let minimal = firmware_images::build_minimal(board, &(profile + fitting), firmware_images::LOG)?;
        return [("master", &images.master), ("slave", &images.slave), ("minimal", &minimal)]
            .into_iter()
            .try_for_each(|(role, path)| describe(role, path));
    };
    let manifest = manifest(options.manifest_path.as_deref())?;
    let images = Package { name: name.clone(), manifest }.build(board)?;
    anyhow::ensure!(!images.is_empty(), "{name} has no program: it needs a src/main.rs");
    images.iter().try_for_each(|path| {
        let role = path.file_name().unwrap_or_default().to_string_lossy();
        describe(&role, path)
    })
}

fn describe(role: &str, path: &Path) -> anyhow::Result<()> {
    let Size { flash, ram } = Facts::read(path)?.size;
    output::line(format_args!(
        "{role:<7}  {flash:>7} bytes of flash  {ram:>6} bytes of static RAM  {}",
        path.display()
    ))
}

/// Lints boards and firmware as they are compiled for a board.
///
/// # Errors
/// When there is a warning.
pub fn clippy(target: &Target) -> anyhow::Result<()> {
    target.board.check_images("clippy")?;
    Ok(firmware_images::clippy(target.board.name(), target.profile.name())?)
}
