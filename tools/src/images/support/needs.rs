//! Third-party programs and packages that some tests and benchmarks need.
//!
//! They come from Debian and from Python's package index. [`provide`] installs missing ones if the user agrees by an
//! option or at the terminal. Otherwise its error lists them and the commands that install them.

use std::fmt;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};

use crate::images::support::output::note;
use crate::images::support::project;

/// Something that is not part of this project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A program in PATH.
    Program {
        /// Name of the executable file.
        name: &'static str,
        /// Debian package that contains it.
        package: &'static str,
    },
    /// Python's modules that make virtual environments; Debian has them in a package of their own.
    VirtualEnvironments,
    /// The packages of `tests/second/python/requirements.txt`, in the virtual environment `target/second/venv`.
    PythonPackages,
}

/// Reads recordings of several buses; has a dissector of CANopen.
pub const TSHARK: Need = Need::Program { name: "tshark", package: "tshark" };
/// Translates logs of candump.
pub const LOG2ASC: Need = Need::Program { name: "log2asc", package: "can-utils" };
/// Runs scripts.
pub const PYTHON: Need = Need::Program { name: "python3", package: "python3" };
/// Emulates an STM32F405, for comparison with the core of the twin.
pub const QEMU: Need = Need::Program { name: "qemu-system-arm", package: "qemu-system-arm" };
/// Assembles the program that both run.
pub const LLVM: Need = Need::Program { name: "llvm-mc", package: "llvm" };
/// Links it.
pub const LLD: Need = Need::Program { name: "ld.lld", package: "lld" };
/// Opens the report of a flight.
pub const CHROMIUM: Need = Need::Program { name: "chromium", package: "chromium" };
/// Runs the shards of a campaign.
pub const PARALLEL: Need = Need::Program { name: "parallel", package: "parallel" };
/// Counts the instructions of a program.
pub const VALGRIND: Need = Need::Program { name: "valgrind", package: "valgrind" };

const REQUIREMENTS: &str = "tests/second/python/requirements.txt";
const ENVIRONMENT: &str = "target/second/venv";

/// Ends with an error unless each line `name==version` of a file is installed.
const CHECK: &str = "
import importlib.metadata, sys
for line in open(sys.argv[1]):
    name, is_pinned, version = line.strip().partition('==')
    if is_pinned and importlib.metadata.version(name) != version:
        sys.exit(1)
";

/// The Python of the virtual environment.
pub fn python() -> PathBuf {
    project::path(ENVIRONMENT).join("bin/python")
}

impl Need {
    /// Returns whether it is installed in the required version.
    pub fn is_there(self) -> bool {
        match self {
            Need::Program { name, .. } => {
                let paths = std::env::var_os("PATH").unwrap_or_default();
                std::env::split_paths(&paths).any(|path| path.join(name).is_file())
            }
            Need::VirtualEnvironments => {
                succeeds(Command::new("python3").args(["-c", "import venv, ensurepip"]))
            }
            Need::PythonPackages => {
                succeeds(Command::new(python()).args(["-c", CHECK]).arg(project::path(REQUIREMENTS)))
            }
        }
    }

    fn package(self) -> Option<&'static str> {
        match self {
            Need::Program { package, .. } => Some(package),
            Need::VirtualEnvironments => Some("python3-venv"),
            Need::PythonPackages => None,
        }
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Need::Program { name, .. } => f.write_str(name),
            Need::VirtualEnvironments => f.write_str("Python's venv and ensurepip"),
            Need::PythonPackages => write!(f, "the Python packages of {REQUIREMENTS}"),
        }
    }
}

/// Checks that all `needs` are installed. Installs missing ones if `install` is set or the user agrees at the terminal.
/// `command` is the command line that installs without a question.
///
/// # Errors
/// When something is missing and must not or cannot be installed; the error contains the commands that install it.
pub fn provide(needs: &[Need], install: bool, command: &str) -> anyhow::Result<()> {
    let missing: Vec<Need> = needs.iter().copied().filter(|need| !need.is_there()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let instructions = instructions(&missing);
    if !install && !is_confirmed(&instructions)? {
        bail!("{instructions}\nor let this command do it:\n    {command}");
    }
    install_all(&missing)?;
    let left: Vec<String> = missing.iter().filter(|need| !need.is_there()).map(Need::to_string).collect();
    ensure!(left.is_empty(), "still missing after the installation: {}", left.join(", "));
    Ok(())
}

/// Lists what is missing and the commands that install it.
fn instructions(missing: &[Need]) -> String {
    let names: Vec<String> = missing.iter().map(Need::to_string).collect();
    let mut text = format!("missing: {}", names.join(", "));
    if let Some(apt) = apt(missing) {
        text += &format!("\non Debian, install the programs as root:\n    {apt}");
    }
    if missing.contains(&Need::PythonPackages) {
        text += &format!(
            "\ninstall the Python packages:\n    python3 -m venv {ENVIRONMENT}\n    \
             {ENVIRONMENT}/bin/python -m pip install --requirement {REQUIREMENTS}"
        );
    }
    text
}

/// The command that installs the Debian packages, if there are any.
fn apt(missing: &[Need]) -> Option<String> {
    let packages: Vec<&str> = missing.iter().filter_map(|need| need.package()).collect();
    (!packages.is_empty()).then(|| {
        format!("apt-get update && apt-get install -y --no-install-recommends {}", packages.join(" "))
    })
}

/// Asks at the terminal. Without a terminal the answer is no.
fn is_confirmed(instructions: &str) -> anyhow::Result<bool> {
    if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        return Ok(false);
    }
    note(instructions);
    write!(io::stderr(), "Install now? [y/N] ")?;
    let mut answer = String::new();
    io::stdin().lock().read_line(&mut answer).context("cannot read the answer")?;
    Ok(["y", "yes"].contains(&answer.trim().to_lowercase().as_str()))
}

fn install_all(missing: &[Need]) -> anyhow::Result<()> {
    if let Some(apt) = apt(missing) {
        ensure!(
            is_root() && Path::new("/usr/bin/apt-get").exists(),
            "only root can install programs, and only on Debian:\n    {apt}"
        );
        note(format_args!("installing: {apt}"));
        run(Command::new("sh").args(["-c", &apt]).env("DEBIAN_FRONTEND", "noninteractive"))?;
    }
    if missing.contains(&Need::PythonPackages) {
        note(format_args!("installing {} into {ENVIRONMENT}: about half a minute", Need::PythonPackages));
        // Empty: a half-finished or older environment is replaced.
        let environment = project::path(ENVIRONMENT);
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&environment))?;
        run(Command::new(python())
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"])
            .arg(project::path(REQUIREMENTS)))
        .context("cannot install the Python packages: is there a network?")?;
    }
    Ok(())
}

/// Returns whether this program may install packages.
pub fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output();
    output.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

fn succeeds(command: &mut Command) -> bool {
    let status = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

/// Runs a command to its end, its output on our stderr.
fn run(command: &mut Command) -> anyhow::Result<()> {
    let status = command.stdin(Stdio::null()).stdout(io::stderr()).status();
    let status = status.with_context(|| format!("cannot run {}", command.get_program().to_string_lossy()))?;
    ensure!(status.success(), "{command:?} failed ({status})");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOT_THERE: Need = Need::Program { name: "no-such-program", package: "no-such-package" };
    const SHELL: Need = Need::Program { name: "sh", package: "dash" };

    #[test]
    fn nothing_is_installed_without_consent() {
        let error = provide(&[SHELL, NOT_THERE], false, "cargo xtask it --install").unwrap_err().to_string();
        assert!(error.starts_with("missing: no-such-program\n"), "{error}");
        assert!(error.contains("install -y --no-install-recommends no-such-package\n"), "{error}");
        assert!(error.ends_with("    cargo xtask it --install"), "{error}");
        assert!(!error.contains("dash") && !error.contains("pip"), "{error}");
    }

    #[test]
    fn what_is_there_needs_no_installation() {
        provide(&[SHELL], false, "").unwrap();
    }

    #[test]
    fn python_packages_have_commands_of_their_own() {
        let text = instructions(&[Need::PythonPackages]);
        assert!(text.contains("-m pip install --requirement tests/second/python/requirements.txt"), "{text}");
        assert!(!text.contains("apt-get"), "{text}");
    }
}
