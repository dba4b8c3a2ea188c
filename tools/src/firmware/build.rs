//! `ecss-can build`: paths and sizes of the images of the user's project, or of the shipped ones.

use std::path::Path;

use clap::Args;

use crate::firmware::Role;
use crate::firmware::own::Project;
use crate::firmware::role::Configuration;
use crate::images::LOG;
use crate::images::support::board::{Board, help};
use crate::images::support::elf::{Facts, Size};
use crate::images::support::{fleet, output};

/// The subcommand.
const BUILD: &str = "build";

/// Command line of `build`.
#[derive(Args, Debug)]
#[command(after_help = "Exit code: 0; 1 when an image cannot be built; 2: wrong command line.")]
pub struct Options {
    /// Images of this project [default: the images of your project; all of this project outside of one, and with the
    /// options --profile, --bit-rate and --one-controller]
    #[arg(value_name = "IMAGE", value_enum, conflicts_with = "Project")]
    images: Vec<Role>,

    /// Board to build for
    #[arg(long, value_name = "BOARD", value_parser = Board::parse, help = of_board())]
    board: Option<Board>,

    /// Configuration of images of this project.
    #[command(flatten)]
    configuration: Configuration,

    /// Packages of the user.
    #[command(flatten)]
    project: Project,
}

/// Returns the help of `--board`.
pub(in crate::firmware) fn of_board() -> String {
    format!("{} [default: {}; for your package the board in its Cargo.toml]", help(), Board::DEFAULT)
}

/// Builds the images, prints paths and sizes.
///
/// # Errors
/// When an image cannot be built or read, or does not start.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let is_shipped = !options.images.is_empty() || options.configuration.is_given();
    let packages = if is_shipped { Vec::new() } else { options.project.packages(BUILD)? };
    for package in &packages {
        for path in options.project.build(BUILD, package, options.board.as_ref(), LOG)? {
            describe(&path.file_name().unwrap_or_default().to_string_lossy(), &path)?;
        }
    }
    if !packages.is_empty() {
        return Ok(());
    }
    let board = options.board.clone().unwrap_or_else(|| Board::shipped(Board::DEFAULT));
    let roles = if options.images.is_empty() { &Role::ALL[..] } else { &options.images };
    let images = options.configuration.build(BUILD, roles, &board, LOG)?;
    images.iter().try_for_each(|(role, path)| describe(role.name(), path))
}

fn describe(role: &str, path: &Path) -> anyhow::Result<()> {
    fleet::image(path)?;
    let Size { flash, ram } = Facts::read(path)?.size;
    output::line(format_args!(
        "{role:<7}  {flash:>7} bytes of flash  {ram:>6} bytes of static RAM  {}",
        path.display()
    ))
}
