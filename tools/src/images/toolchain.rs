//! Selection of the toolchain for the boards.
//!
//! Tried in this order:
//! 1. rustup's toolchain that the folder of the build asks for, by `rust-toolchain.toml`, with its thumb target installed;
//! 2. Debian's `rustc-web` with `rust-web-src`, when installed: it builds `core` for the target, nothing is fetched;
//! 3. `rustup target add`: as the user, without root; not where `RUSTUP_AUTO_INSTALL=0` forbids rustup to install;
//! 4. installing Debian's packages, as root.
//!
//! The environment variable `FIRMWARE_TOOLCHAIN=debian` leaves rustup out.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::images::environment::{clean, of_target};
use crate::images::support::needs::is_root;
use crate::images::support::output::note;
use crate::images::{Error, TARGET, run};

/// A way to compile for [`TARGET`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Toolchain {
    /// rustup's, with the target's precompiled `core`.
    Rustup,
    /// Debian's, building `core`.
    Debian,
}

const DEBIAN_PACKAGES: [(&str, &str); 4] = [
    ("rustc-web", "/usr/bin/rustc"),
    ("cargo-web", "/usr/bin/cargo"),
    ("rust-web-src", "/usr/lib/rustlib/src/rust/library/core/Cargo.toml"),
    ("lld", "/usr/bin/ld.lld"),
];
const DEBIAN_CLIPPY: (&str, &str) = ("rust-web-clippy", "/usr/bin/clippy-driver");

/// Finds a toolchain for a build in the folder `home`, or installs what is missing; `clippy`: including clippy.
///
/// # Errors
/// [`Error::NoToolchain`] with the command to run as root.
pub fn find(home: &Path, clippy: bool) -> Result<Toolchain, Error> {
    let install = match installed(home, clippy) {
        Ok(toolchain) => return Ok(toolchain),
        Err(install) => install,
    };
    if rustup_may_add_target() && add_rustup_target(home) {
        return Ok(Toolchain::Rustup);
    }
    if !Path::new("/usr/bin/apt-get").exists() || !is_root() {
        return Err(Error::NoToolchain(install));
    }
    note(format_args!("rustup has no target {TARGET}; installing Debian's instead: {install}"));
    run(Command::new("sh")
        .args(["-c", &install])
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null()))?;
    Ok(Toolchain::Debian)
}

/// Returns the toolchain that is installed for a build in the folder `home`; `clippy`: including clippy.
///
/// # Errors
/// The command that installs Debian's, to be run as root.
pub fn installed(home: &Path, clippy: bool) -> Result<Toolchain, String> {
    if is_rustup_wanted() && has_rustup_target(home) {
        return Ok(Toolchain::Rustup);
    }
    let wanted = DEBIAN_PACKAGES.into_iter().chain(clippy.then_some(DEBIAN_CLIPPY));
    let missing: Vec<_> =
        wanted.filter(|(_, file)| !Path::new(file).exists()).map(|(package, _)| package).collect();
    if missing.is_empty() {
        return Ok(Toolchain::Debian);
    }
    Err(format!("apt-get update && apt-get install -y {}", missing.join(" ")))
}

fn is_rustup_wanted() -> bool {
    std::env::var("FIRMWARE_TOOLCHAIN").as_deref() != Ok("debian")
}

impl Toolchain {
    /// Cargo of this toolchain in a clean environment.
    pub fn cargo(self) -> Command {
        let mut cargo = match self {
            Toolchain::Rustup => Command::new("cargo"),
            Toolchain::Debian => Command::new("/usr/bin/cargo"),
        };
        clean(&mut cargo);
        // The linker of the toolchain, which overrides a configuration file of cargo.
        let linker = if self == Toolchain::Debian { "ld.lld" } else { "rust-lld" };
        cargo.env(of_target() + "LINKER", linker);
        if self == Toolchain::Debian {
            let path = std::env::var("PATH").unwrap_or_default();
            cargo.env("PATH", format!("/usr/bin:{path}"));
            cargo.env("RUSTC", "/usr/bin/rustc");
            // build-std is not stable; the packaged compiler is.
            cargo.env("RUSTC_BOOTSTRAP", "1");
        }
        cargo
    }

    /// Returns its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Toolchain::Rustup => "rustup's toolchain",
            Toolchain::Debian => "Debian's rustc, core built from source",
        }
    }

    /// Returns the additional arguments of `cargo build`.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Toolchain::Rustup => &[],
            Toolchain::Debian => &["-Zbuild-std=core", "-Zbuild-std-features=compiler-builtins-mem"],
        }
    }
}

fn has_rustup_target(home: &Path) -> bool {
    let output = clean(&mut Command::new("rustc"))
        .current_dir(home)
        .args(["--print", "target-libdir", "--target", TARGET])
        .stderr(Stdio::null())
        .output();
    output.is_ok_and(|output| {
        output.status.success() && Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir()
    })
}

/// Returns whether rustup, if it is there, may add the target. Evaluates rustup's own variable, too.
pub fn rustup_may_add_target() -> bool {
    is_rustup_wanted() && std::env::var("RUSTUP_AUTO_INSTALL").as_deref() != Ok("0")
}

fn add_rustup_target(home: &Path) -> bool {
    note(format_args!("no target {TARGET} yet: rustup target add {TARGET}"));
    clean(&mut Command::new("rustup"))
        .current_dir(home)
        .args(["target", "add", TARGET])
        .env("RUSTUP_MAX_RETRIES", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}
