//! `cargo xtask flash`, with the aliases `cargo master`, `cargo slave` and `cargo minimal`: builds an image, writes it
//! to a board, shows its log.
//!
//! The image is built as all images are, so one command is enough with rustup's target and with Debian's toolchain.
//! probe-rs writes it.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};

use ecss_can_cli::images::support::board::{BitRate, Board, Target};
use ecss_can_cli::images::support::misuse::Misuse;

/// The program that writes to a board.
const PROBE_RS: &str = "probe-rs";

/// Command line of `flash`.
#[derive(Args, Debug)]
#[command(
    after_help = "Needs probe-rs and a debug probe. The log of the image is what DEFMT_LOG says: DEFMT_LOG=debug cargo slave\n\
    Exit code: that of probe-rs; 1 as well when the image cannot be built or probe-rs is missing; 2: wrong command line."
)]
pub struct Options {
    /// Image to flash
    #[arg(value_enum)]
    role: Role,

    /// Board and profile.
    #[command(flatten)]
    target: Target,

    /// The board has one CAN controller and two transceivers (ECSS Figure A-6); for the minimal slave
    #[arg(long)]
    one_controller: bool,

    /// Bit rate of both buses in kbit/s
    #[arg(long, value_name = "KBIT", value_enum, default_value_t = BitRate::Kbit1000)]
    bit_rate: BitRate,

    /// Arguments for `probe-rs run`, for example: -- --probe 0483:374b
    #[arg(last = true, value_name = "ARGUMENTS")]
    probe_rs: Vec<OsString>,
}

/// A node of the spacecraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Role {
    /// The one master
    Master,
    /// Any slave: straps give its Node-ID
    Slave,
    /// Any slave of the minimal set (ECSS 9)
    Minimal,
}

impl Options {
    /// Returns the features of the image in addition to board, profile and bit rate.
    fn fitting(&self) -> Result<&'static str, Misuse> {
        match (self.one_controller, self.role) {
            (false, _) => Ok(""),
            (true, Role::Minimal) => Ok("+one-controller"),
            (true, Role::Master | Role::Slave) => Err(Misuse::of(
                "flash",
                "--one-controller is for the minimal slave alone: cargo minimal --one-controller",
            )),
        }
    }
}

/// Builds the image, and replaces this program by `probe-rs run`.
///
/// # Errors
/// When the image cannot be built, or probe-rs is missing or fails.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let (Target { board, profile }, fitting) = (&options.target, options.fitting()?);
    board.check_images("flash")?;
    find_probe_rs()?;
    let log = std::env::var("DEFMT_LOG").unwrap_or(ecss_can_cli::images::LOG.into());
    let profile = options.bit_rate.configuration(*profile);
    let images = || ecss_can_cli::images::build_logging(board.board_crate(), &profile, &log);
    let image = match options.role {
        Role::Master => images()?.master,
        Role::Slave => images()?.slave,
        Role::Minimal => {
            ecss_can_cli::images::build_minimal(board.board_crate(), &(profile + fitting), &log)?
        }
    };
    write(board, &image, &options.probe_rs)
}

/// Replaces this program by `probe-rs run` of an image, with `arguments`.
///
/// # Errors
/// When probe-rs fails.
pub fn write(board: &Board, image: &Path, arguments: &[OsString]) -> anyhow::Result<()> {
    let mut probe_rs = Command::new(PROBE_RS);
    probe_rs.args(["run", "--chip", board.chip()]).arg(image).args(arguments);
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
             or as https://probe.rs/docs/getting-started/installation/ says; to build only: cargo xtask firmware"
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
    if code == 0 { Ok(()) } else { Err(ecss_can_cli::images::support::output::Silently(code).into()) }
}
