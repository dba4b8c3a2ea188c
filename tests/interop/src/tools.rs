//! Tools that are not ours: where they are, and how they come there.
//!
//! Everything is done under one file lock, so that test processes install once. Python packages come by name from the
//! package index into a virtual environment of this workspace; programs come from Debian, if this is a Debian and we are
//! root. Otherwise the error says what to run.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};

/// Python packages and their versions; the copy in the environment says what is installed there.
const REQUIREMENTS: &str = "requirements.txt";

/// A program and the Debian package it comes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tool {
    program: &'static str,
    package: &'static str,
}

/// Reads recordings of several buses, with a dissector of CANopen.
pub const TSHARK: Tool = Tool { program: "tshark", package: "tshark" };

/// Translates logs of candump.
pub const LOG2ASC: Tool = Tool { program: "log2asc", package: "can-utils" };

/// Runs scripts and makes virtual environments.
const PYTHON: Tool = Tool { program: "python3", package: "python3" };

/// The Debian package that lets Python make virtual environments.
const VENV: &str = "python3-venv";

/// Directory of the scripts.
pub fn scripts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("python")
}

/// Root of the workspace.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new(".")).to_path_buf()
}

/// Makes sure that a program is there.
///
/// # Errors
/// When it is missing and cannot be installed; the error says how to do it.
pub fn provide(tool: Tool) -> anyhow::Result<()> {
    if is_there(tool) {
        return Ok(());
    }
    locked(|_| if is_there(tool) { Ok(()) } else { install(&[tool.package]) })
}

/// The Python that has the packages of the list.
///
/// # Errors
/// When they are missing and cannot be installed; the error says why.
pub fn python() -> anyhow::Result<PathBuf> {
    locked(|directory| {
        let environment = directory.join("venv");
        let python = environment.join("bin/python");
        let wanted = fs::read(scripts().join(REQUIREMENTS)).context("cannot read the list of packages")?;
        let stamp = environment.join(REQUIREMENTS);
        if fs::read(&stamp).is_ok_and(|installed| installed == wanted) && python.exists() {
            return Ok(python);
        }
        if !can_make_environments() {
            install(&[PYTHON.package, VENV])?;
        }
        note(format_args!(
            "installing python-can, canopen and others into {}, about half a minute",
            environment.display()
        ));
        run(Command::new(PYTHON.program).args(["-m", "venv", "--clear"]).arg(&environment))?;
        run(Command::new(&python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"])
            .arg(scripts().join(REQUIREMENTS)))
        .context(
            "cannot install the packages of tests/interop/python/requirements.txt: is there a network?",
        )?;
        // Last of all: an installation that was interrupted begins anew.
        fs::write(&stamp, wanted).with_context(|| format!("cannot write {}", stamp.display()))?;
        Ok(python)
    })
}

/// Works in our directory while nobody else does.
fn locked<R>(work: impl FnOnce(&Path) -> anyhow::Result<R>) -> anyhow::Result<R> {
    let directory = workspace().join("target/interop");
    let unusable = || format!("cannot use {}", directory.display());
    fs::create_dir_all(&directory).with_context(unusable)?;
    // Held until the file is closed.
    let lock = File::create(directory.join("lock")).with_context(unusable)?;
    lock.lock().with_context(unusable)?;
    work(&directory)
}

fn is_there(tool: Tool) -> bool {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&paths).any(|path| path.join(tool.program).is_file())
}

fn can_make_environments() -> bool {
    let imports = Command::new(PYTHON.program)
        .args(["-c", "import venv, ensurepip"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    imports.is_ok_and(|status| status.success())
}

fn install(packages: &[&str]) -> anyhow::Result<()> {
    let packages = packages.join(" ");
    let command = format!("apt-get update && apt-get install -y --no-install-recommends {packages}");
    let root = Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0");
    if !root || !Path::new("/usr/bin/apt-get").exists() {
        bail!("missing: {packages}; on Debian, run as root\n    {command}");
    }
    note(format_args!("missing: {packages}; installing, about a minute: {command}"));
    run(Command::new("sh")
        .args(["-c", &command])
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null()))
}

/// Prints a line on stderr past the test harness, which shows its own capture of stderr only after a failure.
pub(crate) fn note(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Runs a command to its end, its output on our stderr.
fn run(command: &mut Command) -> anyhow::Result<()> {
    let status = command
        .stdout(std::io::stderr())
        .status()
        .with_context(|| format!("cannot run {}", command.get_program().to_string_lossy()))?;
    ensure!(status.success(), "{command:?} failed ({status})");
    Ok(())
}
