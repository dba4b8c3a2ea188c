//! What a computer has: programs, toolchains, rules for devices.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::images::support::needs::is_root;
use crate::images::{Toolchain, clean, installed, rustup_may_add_target};

/// Folders with rules for devices, on Linux.
const RULES: [&str; 4] =
    ["/etc/udev/rules.d", "/run/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"];

/// What a computer has.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    /// Output of `rustc --version`.
    pub(super) compiler: Option<String>,
    /// Toolchain for the target, or the command that installs Debian's.
    pub(super) toolchain: Result<Toolchain, String>,
    /// It has rustup.
    pub(super) has_rustup: bool,
    /// The environment permits rustup to add a target.
    pub(super) may_add_target: bool,
    /// Linker of rustup's toolchain.
    pub(super) rust_lld: Option<PathBuf>,
    /// Linker of programs for this computer.
    pub(super) cc: Option<PathBuf>,
    /// Output of `probe-rs --version`.
    pub(super) probe_rs: Option<String>,
    /// Reason why this user may use debug probes; `None`: they may not.
    pub(super) may_use_probes: Option<String>,
}

impl Machine {
    /// Examines this computer, for images that are built in the current folder.
    pub(super) fn this() -> Machine {
        let here = env::current_dir().unwrap_or_default();
        Machine {
            compiler: said("rustc", &["--version"]),
            toolchain: installed(&here, false),
            has_rustup: in_path("rustup").is_some(),
            may_add_target: rustup_may_add_target(),
            rust_lld: rust_lld(),
            cc: in_path("cc"),
            probe_rs: said("probe-rs", &["--version"]),
            may_use_probes: may_use_probes(),
        }
    }
}

/// First line that a program prints.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let output = clean(&mut Command::new(program)).args(arguments).stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).lines().next()?.trim().to_owned();
    output.status.success().then_some(text)
}

fn in_path(program: &str) -> Option<PathBuf> {
    let paths = env::var_os("PATH")?;
    env::split_paths(&paths).map(|path| path.join(program)).find(|path| path.is_file())
}

/// The linker in the folder of the compiler.
fn rust_lld() -> Option<PathBuf> {
    let libraries = said("rustc", &["--print", "target-libdir"])?;
    let linker = Path::new(&libraries).parent()?.join("bin/rust-lld");
    linker.is_file().then_some(linker)
}

fn may_use_probes() -> Option<String> {
    if !cfg!(target_os = "linux") {
        return Some("no rules are needed on this system".into());
    }
    if is_root() {
        return Some("this user is root".into());
    }
    let files = RULES.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten().flatten();
    let mut paths = files.map(|file| file.path());
    let of_probes =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().contains("probe-rs"));
    paths.find(of_probes).map(|path| path.display().to_string())
}
