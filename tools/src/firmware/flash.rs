//! `ecss-can flash`: builds an image, writes it to a board, shows its log.
//!
//! The image is built as all images are, so one command is enough with rustup's target and with Debian's toolchain.
//! probe-rs writes it.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use can_twin::model::Part;
use clap::{Args, ValueEnum};

use crate::firmware::Role;
use crate::firmware::build::of_board;
use crate::firmware::own::Project;
use crate::firmware::role::Configuration;
use crate::images::CHIPS;
use crate::images::support::board::Board;
use crate::images::support::misuse::Misuse;
use crate::images::support::{elf, fleet};

/// The subcommand.
const FLASH: &str = "flash";
/// The program that writes to a board.
const PROBE_RS: &str = "probe-rs";

/// Command line of `flash`.
#[derive(Args, Debug)]
#[command(
    after_help = "Needs probe-rs and a debug probe. The log of the image is what DEFMT_LOG says: DEFMT_LOG=debug ecss-can flash slave\n\
    Exit code: that of probe-rs; 1 as well when the image cannot be built or probe-rs is missing; 2: wrong command line."
)]
pub struct Options {
    /// Image to flash: master, slave or minimal of this project, or the path of an ELF file [default: the image of your project]
    #[arg(value_name = "IMAGE", value_parser = Image::parse, conflicts_with = "Project")]
    image: Option<Image>,

    /// Board to flash
    #[arg(long, value_name = "BOARD", value_parser = Board::parse, help = of_board())]
    board: Option<Board>,

    /// Configuration of an image of this project.
    #[command(flatten)]
    configuration: Configuration,

    /// Package of the user.
    #[command(flatten)]
    project: Project,

    /// Arguments for `probe-rs run`, for example: -- --probe 0483:374b
    #[arg(last = true, value_name = "ARGUMENTS")]
    probe_rs: Vec<OsString>,
}

/// An image that is flashed.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Image {
    /// An image of this project.
    Shipped(Role),
    /// An ELF file.
    File(PathBuf),
}

impl Image {
    fn parse(text: &str) -> Result<Image, String> {
        if let Ok(role) = Role::from_str(text, false) {
            return Ok(Image::Shipped(role));
        }
        let path = PathBuf::from(text);
        if !path.is_file() {
            return Err(
                "no such image; allowed are master, slave, minimal, or the path of an ELF file".into()
            );
        }
        Ok(Image::File(path))
    }
}

/// Builds the image if it is no file, and replaces this program by `probe-rs run`.
///
/// # Errors
/// When the image cannot be built, its chip is not known, or probe-rs is missing or fails.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let log = std::env::var("DEFMT_LOG").unwrap_or(crate::images::LOG.into());
    let board = options.board.as_ref();
    match &options.image {
        Some(Image::Shipped(role)) => {
            let board = board.cloned().unwrap_or_else(|| Board::shipped(Board::DEFAULT));
            options.configuration.check(FLASH, &[*role])?;
            board.check_images(FLASH)?;
            find_probe_rs()?;
            let images = options.configuration.build(FLASH, &[*role], &board, &log)?;
            let (_, image) = images.first().context("no image was built")?;
            write(board.chip(), image, &options.probe_rs)
        }
        Some(Image::File(path)) => own(path, options),
        None => {
            let packages = options.project.packages(FLASH)?;
            let [package] = &packages[..] else { return Err(no_image(&packages).into()) };
            find_probe_rs()?;
            let images = options.project.build(FLASH, package, board, &log)?;
            let [image] = &images[..] else {
                let paths: Vec<_> = images.iter().map(|path| path.display().to_string()).collect();
                let text = format!(
                    "{} has {} programs: give one of {}",
                    package.name,
                    paths.len(),
                    paths.join(", ")
                );
                return Err(Misuse::of(FLASH, text).into());
            };
            own(image, options)
        }
    }
}

/// Returns the error that not one package is selected.
fn no_image(packages: &[crate::images::Package]) -> Misuse {
    let names: Vec<_> = packages.iter().map(|package| package.name.as_str()).collect();
    if names.is_empty() {
        return Misuse::of(
            FLASH,
            "no image: give master, slave, minimal, the path of an ELF file, or --package NAME",
        );
    }
    Misuse::of(
        FLASH,
        format!("several packages have an image: give --package with one of {}", names.join(", ")),
    )
}

/// Flashes an image of the user's.
fn own(path: &Path, options: &Options) -> anyhow::Result<()> {
    let refuse = |error: anyhow::Error| Misuse::of(FLASH, format!("{}: {error:#}", path.display()));
    let image = fleet::image(path).map_err(|error| Misuse::of(FLASH, format!("{error:#}")))?;
    let chip = match &options.board {
        Some(board) => {
            image.check_part(board.model().part).map_err(|misfit| refuse(misfit.into()))?;
            board.chip().to_owned()
        }
        None => chip(path).map_err(refuse)?,
    };
    find_probe_rs()?;
    write(&chip, path, &options.probe_rs)
}

/// Returns the chip that an image was linked for, as probe-rs names it. Chips of one DEV_ID are flashed in the same way.
fn chip(image: &Path) -> anyhow::Result<String> {
    let id =
        elf::device_id(image)?.context("it has no symbol `__device_id` that names its chip: give --board")?;
    let of_chip =
        |chip: &&&str| Part::named(&chip.to_ascii_uppercase()).is_ok_and(|part| part.device_id() == id);
    let chip = CHIPS.iter().find(of_chip);
    let chip =
        chip.with_context(|| format!("no chip that is supported has DEV_ID {id:#05x}: give --board"))?;
    Ok(chip.to_ascii_uppercase())
}

/// Replaces this program by `probe-rs run` of an image, with `arguments`.
///
/// # Errors
/// When probe-rs fails.
pub fn write(chip: &str, image: &Path, arguments: &[OsString]) -> anyhow::Result<()> {
    let mut probe_rs = Command::new(PROBE_RS);
    probe_rs.args(["run", "--chip", chip]).arg(image).args(arguments);
    replace_by(probe_rs)
}

/// Looks for probe-rs before a build of a minute.
///
/// # Errors
/// When it is missing. The error says how to install it.
pub fn find_probe_rs() -> anyhow::Result<()> {
    let version =
        Command::new(PROBE_RS).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    match version {
        Err(error) if error.kind() == ErrorKind::NotFound => bail!(
            "probe-rs is not installed, or not in PATH: it writes the image to the board and shows its log; install it with\n    \
             cargo install probe-rs-tools --locked\n\
             or as https://probe.rs/docs/getting-started/installation/ says; to build only: ecss-can build"
        ),
        outcome => outcome.map(drop).context("cannot run probe-rs"),
    }
}

/// Replaces this program by `program`, which gets Ctrl-C and sets the exit code.
#[cfg(unix)]
fn replace_by(mut program: Command) -> anyhow::Result<()> {
    use std::os::unix::process::CommandExt;
    Err(program.exec()).context("cannot run probe-rs")
}

/// Runs the program to its end, and exits with its exit code.
#[cfg(not(unix))]
fn replace_by(mut program: Command) -> anyhow::Result<()> {
    let status = program.status().context("cannot run probe-rs")?;
    let code = status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1);
    if code == 0 { Ok(()) } else { Err(crate::images::support::output::Silently(code).into()) }
}
