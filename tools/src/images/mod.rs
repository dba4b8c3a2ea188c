//! Builds the firmware images with any available toolchain.
//!
//! Most users need only [`build`]: it finds a toolchain, prints one line, and builds under a file lock, so that test
//! processes that need the same images build them once. It is never called from a build script. Ctrl-C ends a build and
//! the wait for another one, unless the program handles it: call [`build`] before you handle signals.
//!
//! [`support`] contains code that the commands of tools and xtask share.

mod board_crate;
mod checkout;
mod chips;
mod choice;
mod elsewhere;
mod environment;
mod manifest;
mod once;
mod package;
mod seal;
mod shipped;
mod site;
mod sources;
pub mod support;
mod target;
mod toolchain;

use std::env;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

pub use board_crate::BoardCrate;
#[cfg(feature = "program")]
pub(crate) use board_crate::read as package_of;
pub use chips::{CHIPS, check_chips};
pub use choice::Choice;
#[cfg(feature = "program")]
pub(crate) use elsewhere::OF_BOARDS;
pub use environment::{clean, host_cargo};
use indicatif::{ProgressBar, ProgressStyle};
pub use package::{Package, Refusal};
use site::Site;
use support::output::note;
pub use target::{results, target};
#[cfg(feature = "program")]
pub(crate) use toolchain::{Toolchain, installed, rustup_may_add_target};

/// Images of master and slave, for boards and for the twin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Images {
    /// ELF file of the master image.
    pub master: PathBuf,
    /// ELF file of the slave image.
    pub slave: PathBuf,
}

/// Reason why there are no images.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Neither rustup nor Debian gives a toolchain for the target.
    #[error(
        "no toolchain for {TARGET}: rustup has no such target and cannot fetch it; on Debian, run as root\n    {0}"
    )]
    NoToolchain(String),
    /// A command could not be started.
    #[error("cannot run {0}: {1}")]
    Spawn(String, io::Error),
    /// A command failed; its output went to stderr.
    #[error("{0} failed ({1})")]
    Failed(String, std::process::ExitStatus),
    /// The build directory cannot be used.
    #[error("cannot use {0}: {1}")]
    Directory(PathBuf, io::Error),
    /// A manifest is not TOML, or lacks something; or the folder of a board has no chip that is supported.
    #[error("{0}: {1}")]
    Manifest(PathBuf, String),
    /// A workspace has no package of this name.
    #[error("{manifest} has no package {name}; allowed are {}", packages.join(", "))]
    NoPackage {
        /// Name of the missing package.
        name: String,
        /// `Cargo.toml` of the workspace.
        manifest: PathBuf,
        /// Names of the packages of the workspace.
        packages: Vec<String>,
    },
}

/// Target triple of every supported board.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Package of the programs that check a single board.
const CHECKS: &str = "checks";

const PACKAGES: [&str; 2] = ["master", "slave"];

/// Package of the minimal slave (ECSS 9).
const MINIMAL: &str = "minimal";

/// Packages of the examples, written as by a user, with their own profile.
const EXAMPLES: [&str; 2] = ["thermometer", "thermometer-master"];

/// Package used only by tests, on one board; and its program that uses only chip support.
const FIXTURES: &str = "fixtures";
const FIXTURES_FLY: &str = "pyboard-v11";
const BARE: &str = "test-bare";

/// Package with third-party drivers, used only by tests.
const FOREIGN: &str = "foreign";

/// Log filter of the images, in the format of defmt, as in `.cargo/config.toml`.
pub const LOG: &str = "info";

/// Duration of the first build.
const FIRST_TIME: &str = "about two minutes on two cores: core, HAL and protocol";

/// Builds master and slave for a board (`pyboard-v11`, or a crate elsewhere) and a mission profile (`librecube`, or `standard`),
/// which may have a bit rate (`standard+kbit-125`).
///
/// # Errors
/// See [`Error`]; each says what to do.
pub fn build<'a>(board: impl Into<BoardCrate<'a>>, profile: &str) -> Result<Images, Error> {
    build_logging(board, profile, LOG)
}

/// Returns the images of an earlier [`build`], if there was one.
pub fn built<'a>(board: impl Into<BoardCrate<'a>>, profile: &str) -> Option<Images> {
    let directory = folder(&Site::of(board.into()).ok()?, profile, LOG);
    let [master, slave] = PACKAGES.map(|package| directory.join(package));
    (master.is_file() && slave.is_file()).then_some(Images { master, slave })
}

/// As [`build`], with another filter of the log than [`LOG`].
///
/// # Errors
/// See [`Error`]; each says what to do.
pub fn build_logging<'a>(
    board: impl Into<BoardCrate<'a>>,
    profile: &str,
    log: &str,
) -> Result<Images, Error> {
    let [master, slave] = programs(board.into(), profile, log, &PACKAGES, PACKAGES)?;
    Ok(Images { master, slave })
}

/// Builds the image of the package `name`, `master`, `slave` or `minimal`, with this filter of the log. Returns its ELF file.
///
/// # Errors
/// See [`Error`]; each says what to do.
pub fn build_image<'a>(
    board: impl Into<BoardCrate<'a>>,
    name: &str,
    profile: &str,
    log: &str,
) -> Result<PathBuf, Error> {
    let [image] = programs(board.into(), profile, log, &[name], [name])?;
    Ok(image)
}

/// Builds a program of the package `checks`, which needs no bus; returns its ELF file.
///
/// # Errors
/// See [`Error`]; each says what to do.
pub fn build_check<'a>(board: impl Into<BoardCrate<'a>>, program: &str) -> Result<PathBuf, Error> {
    let [image] = programs(board.into(), "standard", LOG, &[CHECKS], [program])?;
    Ok(image)
}

/// Builds a program of `firmware/fixtures` for the board of tests; returns its ELF file.
///
/// # Errors
/// See [`Error`]; each says what to do.
pub fn build_fixture(name: &str, profile: &str) -> Result<PathBuf, Error> {
    let kind = if name == BARE { "bare" } else { "runtime" };
    let profile = format!("{profile}+{kind}");
    let [image] = programs(FIXTURES_FLY.into(), &profile, LOG, &[FIXTURES], [name])?;
    Ok(image)
}

/// Builds the image of the minimal slave with this filter of the log, usually [`LOG`], and returns its ELF file. It is
/// built separately, because it uses fewer features of `ecss-can-stm32f4`. For a board with one controller the profile
/// has `+one-controller` behind it.
///
/// # Errors
/// See [`Error`]; each says what to do.
pub fn build_minimal<'a>(
    board: impl Into<BoardCrate<'a>>,
    profile: &str,
    log: &str,
) -> Result<PathBuf, Error> {
    build_image(board, MINIMAL, profile, log)
}

/// Returns the image of an earlier [`build_minimal`] with the log of [`LOG`], if there was one.
pub fn built_minimal<'a>(board: impl Into<BoardCrate<'a>>, profile: &str) -> Option<PathBuf> {
    let image = folder(&Site::of(board.into()).ok()?, profile, LOG).join(MINIMAL);
    image.is_file().then_some(image)
}

/// Lints boards and firmware, compiled for a board of this project; warnings are errors.
///
/// # Errors
/// See [`Error`].
pub fn clippy(board: &str, profile: &str) -> Result<(), Error> {
    let root = workspace();
    let task = format!("lint firmware for {board}, profile {profile}");
    let job = Job { home: &root, prepare: &|| Ok(()), task, log: LOG, is_locked: true };
    let what = [
        packages(&PACKAGES, Some(board), profile),
        packages(&[CHECKS], Some(board), "standard"),
        drivers_of_others(board)?,
    ];
    let command =
        ["clippy", "--package", "ecss-can", "--package", "ecss-can-stm32f4", "--package", "ecss-can-runtime"];
    job.run(&command, &what.concat(), &["--", "-D", "warnings"], run)?;
    // Without ecss-can, and without the features that images have.
    job.run(&["clippy", "--package", "async-canopen"], &[], &["--", "-D", "warnings"], run)?;
    // The examples select their own board.
    job.run(&["clippy"], &packages(&EXAMPLES, None, "standard"), &["--", "-D", "warnings"], run)?;
    // Separate from packages that need more of a board, or a log.
    for kind in ["bare", "runtime"].into_iter().filter(|_| board == FIXTURES_FLY) {
        job.run(&["clippy"], &packages(&[FIXTURES], Some(board), kind), &["--", "-D", "warnings"], run)?;
    }
    if board == FIXTURES_FLY {
        let what = packages(&[chips::ON_EMBASSY], Some(board), "standard");
        job.run(&["clippy"], &what, &["--", "-D", "warnings"], run)?;
    }
    for profile in [profile, &format!("{profile}+one-controller")] {
        job.run(&["clippy"], &packages(&[MINIMAL], Some(board), profile), &["--", "-D", "warnings"], run)?;
    }
    Ok(())
}

/// Writes the documentation of a package of the workspace for the target, without that of its dependencies. Warnings are errors.
///
/// # Errors
/// See [`Error`].
pub fn document(package: &str, features: &[String]) -> Result<(), Error> {
    let root = workspace();
    let task = format!("document {package}");
    let job = Job { home: &root, prepare: &|| Ok(()), task, log: LOG, is_locked: true };
    let mut what = vec!["--package".to_owned(), package.to_owned()];
    what.extend(features.iter().flat_map(|feature| ["--features".to_owned(), feature.clone()]));
    job.run(&["doc", "--no-deps"], &what, &[], |cargo| run(cargo.env("RUSTDOCFLAGS", "-D warnings")))
}

/// Returns the arguments for the third-party drivers; none if they have no feature for the board.
fn drivers_of_others(board: &str) -> Result<Vec<String>, Error> {
    let features = Package::of_workspace(FOREIGN).choice()?.features;
    let is_supported = features.iter().any(|feature| feature == board);
    Ok(if is_supported { packages(&[FOREIGN], Some(board), &format!("{board}-bxcan")) } else { Vec::new() })
}

/// Returns the arguments for packages of firmware and their features; `board` is one of them, if the packages have
/// boards as features.
fn packages(packages: &[&str], board: Option<&str>, profile: &str) -> Vec<String> {
    let mut what = Vec::new();
    for package in packages {
        what.extend(["--package", package].map(str::to_owned));
        for feature in board.into_iter().chain(profile.split('+').filter(|feature| *feature != "standard")) {
            what.extend(["--features".to_owned(), format!("{package}/{feature}")]);
        }
    }
    what
}

/// Builds programs of packages of firmware. Returns a copy of each program, named by its path in the output of cargo.
fn programs<const N: usize>(
    board: BoardCrate,
    profile: &str,
    log: &str,
    of: &[&str],
    names: [&str; N],
) -> Result<[PathBuf; N], Error> {
    let site = Site::of(board)?;
    // A generated workspace has no features for boards.
    let feature = site.elsewhere.is_none().then_some(&*site.name);
    let mut what = packages(of, feature, profile);
    what.extend(names.iter().flat_map(|name| ["--bin", name]).map(str::to_owned));
    let task = format!("build {} for {}, profile {profile}", names.join(" and "), site.name);
    let home = site.home();
    let job = Job { home: &home, prepare: &|| site.write(), task, log, is_locked: site.is_locked() };
    let to = folder(&site, profile, log);
    let from = job.target_dir().join(TARGET).join("firmware");
    once::once(format!("{} {log} {}", site.id, what.join(" ")), || {
        job.run(&["build"], &what, &[], |cargo| {
            run(cargo)?;
            names.iter().map(|name| keep(&from.join(name), &to)).collect()
        })
    })?;
    Ok(names.map(|name| to.join(Path::new(name).file_name().unwrap_or_default())))
}

/// One run of cargo for the target.
struct Job<'a> {
    /// Working directory.
    home: &'a Path,
    /// Writes the working directory, if it is generated. Called under the lock.
    prepare: &'a dyn Fn() -> Result<(), Error>,
    /// Description for messages.
    task: String,
    /// Filter of the log.
    log: &'a str,
    /// `Cargo.lock` must not change.
    is_locked: bool,
}

impl Job<'_> {
    /// Returns the directory in which cargo builds. All boards and profiles share common parts. Another filter of the
    /// log has its own directory, because defmt reads the filter in all crates that log.
    fn target_dir(&self) -> PathBuf {
        target::firmware().join(if self.log == LOG { "build" } else { "build-log" })
    }

    /// Takes the lock and calls `run` with a cargo command.
    fn run<T>(
        &self,
        command: &[&str],
        what: &[String],
        rest: &[&str],
        run: impl FnOnce(&mut Command) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let target_dir = self.target_dir();
        let unusable = |error| Error::Directory(target_dir.clone(), error);
        fs::create_dir_all(&target_dir).map_err(unusable)?;
        // Held until the file is closed.
        let lock = File::create(target::firmware().join("lock")).map_err(unusable)?;
        take(&lock).map_err(unusable)?;

        (self.prepare)()?;
        let toolchain = toolchain::find(self.home, command[0] == "clippy")?;
        let task = format!("{}: {}", self.task, toolchain.name());
        let is_first = !target_dir.join(TARGET).exists();
        // In the first build cargo shows its own progress, crate by crate.
        let progress = if is_first {
            note(format_args!("{task}; the first time {FIRST_TIME}"));
            None
        } else {
            Some(spinner(&task))
        };
        let mut cargo = toolchain.cargo();
        // Set only here, so that images do not depend on the user's environment.
        cargo.env("DEFMT_LOG", self.log);
        // These take precedence over the same settings in a configuration file of cargo.
        cargo.env("CARGO_ENCODED_RUSTFLAGS", flags().join("\x1F"));
        cargo.env("CARGO_INCREMENTAL", "0");
        for wrapper in ["RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER"] {
            cargo.env(wrapper, "");
        }
        cargo.env("CARGO_BUILD_BUILD_DIR", &target_dir);
        cargo.current_dir(self.home).args(command).args(toolchain.arguments());
        cargo.args((!is_first).then_some("--quiet"));
        cargo.args(["--profile", "firmware", "--target", TARGET]);
        cargo.args(self.is_locked.then_some("--locked"));
        cargo.arg("--target-dir").arg(&target_dir);
        cargo.args(what).args(rest);
        let outcome = run(&mut cargo);
        progress.iter().for_each(ProgressBar::finish_and_clear);
        outcome
    }
}

/// The flags of the compiler. Panics name files of packages without the user's directory: this saves 500 bytes and
/// makes images independent of the user. Files of a checkout have the same names in a package that depends on it by path.
/// Debug information contains complete paths.
fn flags() -> Vec<String> {
    let cargo_home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let cargo_home = cargo_home.or_else(|| Some(env::home_dir()?.join(".cargo"))).unwrap_or_default();
    let registries = fs::read_dir(cargo_home.join("registry/src")).into_iter().flatten().flatten();
    let mut flags: Vec<_> =
        registries.map(|registry| format!("--remap-path-prefix={}/=", registry.path().display())).collect();
    flags.sort();
    flags.push(format!("--remap-path-prefix={}/=", workspace().display()));
    flags.push("--remap-path-scope=macro".to_owned());
    flags
}

/// Folder with the images of a configuration.
fn folder(site: &Site, profile: &str, log: &str) -> PathBuf {
    target::firmware().join(configuration(&site.id, profile, log))
}

/// Name of the directory with the images of a configuration: those of two configurations never overwrite each other.
/// All filters of the log other than [`LOG`] share a directory, because no test uses those images.
fn configuration(board: &str, profile: &str, log: &str) -> String {
    let suffix = if log == LOG { "" } else { "-log" };
    format!("{board}-{profile}{suffix}")
}

/// Copies an image, with its [seal], unless the copy exists: the next build of another configuration overwrites the
/// output of cargo.
fn keep(elf: &Path, to: &Path) -> Result<PathBuf, Error> {
    let copy = to.join(elf.file_name().unwrap_or_default());
    let unusable = |error| Error::Directory(copy.clone(), error);
    let mut image = fs::read(elf).map_err(unusable)?;
    seal::write(&mut image);
    if fs::read(&copy).is_ok_and(|there| there == image) {
        return Ok(copy);
    }
    fs::create_dir_all(to).map_err(unusable)?;
    // Written atomically, because another process may be reading it.
    let new = copy.with_extension("new");
    fs::write(&new, image).and_then(|()| fs::rename(&new, &copy)).map_err(unusable)?;
    Ok(copy)
}

/// Locks the file. Prints a message if it has to wait.
fn take(lock: &File) -> io::Result<()> {
    match lock.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::Error(error)) => Err(error),
        Err(TryLockError::WouldBlock) => {
            let progress = spinner("waiting for another build of the firmware to end");
            let outcome = lock.lock();
            progress.finish_and_clear();
            outcome
        }
    }
}

/// Root of the repository in which this program was built. The folder may have been removed since.
fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(1).unwrap_or(Path::new(".")).to_path_buf()
}

/// Shows a line with a running clock on a terminal, and a plain line elsewhere.
fn spinner(message: &str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    if bar.is_hidden() {
        note(message);
    }
    let style = ProgressStyle::with_template("{spinner} {msg} [{elapsed}]")
        .unwrap_or_else(|_| ProgressStyle::default_spinner());
    bar.set_style(style);
    bar.set_message(message.to_owned());
    bar.enable_steady_tick(std::time::Duration::from_millis(120));
    bar
}

/// Runs a command to its end, its output on our stderr.
fn run(command: &mut Command) -> Result<(), Error> {
    let line = command_line(command);
    match command.stdout(std::io::stderr()).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::Failed(line, status)),
        Err(error) => Err(Error::Spawn(line, error)),
    }
}

/// Runs cargo to its end. Returns its command line and its output.
fn output(cargo: &mut Command) -> Result<(String, Output), Error> {
    let line = command_line(cargo);
    let output = cargo.stderr(Stdio::inherit()).output();
    output.map(|output| (line.clone(), output)).map_err(|error| Error::Spawn(line, error))
}

fn command_line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_was_built_for_a_board_that_does_not_exist() {
        assert_eq!(built("pyboard-v12", "librecube"), None);
    }

    #[test]
    fn other_log_never_overwrites_usual_images() {
        assert_eq!(configuration("pyboard-v11", "librecube", LOG), "pyboard-v11-librecube");
        assert_ne!(configuration("pyboard-v11", "librecube", "debug"), "pyboard-v11-librecube");
    }

    #[test]
    fn usual_log_is_that_of_the_cargo_configuration() {
        let config = fs::read_to_string(workspace().join(".cargo/config.toml")).expect("it is there");
        assert!(config.contains(&format!("\nDEFMT_LOG = \"{LOG}\"\n")), "{config}");
    }
}
