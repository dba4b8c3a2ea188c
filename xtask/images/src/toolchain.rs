//! Which toolchain compiles for the boards.
//!
//! Tried in this order, because it needs the least and comes closest to the pinned toolchain:
//! 1. rustup's pinned toolchain, its thumb target installed;
//! 2. the same after `rustup target add`, where rustup can fetch it;
//! 3. Debian's `rustc-web`, which compiles `core` from `rust-web-src` for the target;
//! 4. the same after installing these packages, as root.
//!
//! The environment variable `FIRMWARE_TOOLCHAIN=debian` skips the first two.

use std::fmt;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::environment::clean;
use crate::{Error, TARGET, run};

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

/// Finds a toolchain or installs what is missing; `clippy`: one that lints, too.
///
/// # Errors
/// [`Error::NoToolchain`] with the command to run as root.
pub fn find(clippy: bool) -> Result<Toolchain, Error> {
    let debian_wanted = std::env::var("FIRMWARE_TOOLCHAIN").is_ok_and(|way| way == "debian");
    if !debian_wanted && (has_rustup_target() || add_rustup_target()) {
        return Ok(Toolchain::Rustup);
    }
    let wanted = DEBIAN_PACKAGES.into_iter().chain(clippy.then_some(DEBIAN_CLIPPY));
    let missing: Vec<_> =
        wanted.filter(|(_, file)| !Path::new(file).exists()).map(|(package, _)| package).collect();
    if missing.is_empty() {
        return Ok(Toolchain::Debian);
    }
    let install = format!("apt-get update && apt-get install -y {}", missing.join(" "));
    if !Path::new("/usr/bin/apt-get").exists() || !is_root() {
        return Err(Error::NoToolchain(install));
    }
    eprintln!("rustup has no target {TARGET}; installing Debian's instead: {install}");
    run(Command::new("sh")
        .args(["-c", &install])
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null()))?;
    Ok(Toolchain::Debian)
}

impl Toolchain {
    /// Cargo of this toolchain in a clean environment.
    pub fn cargo(self) -> Command {
        let mut cargo = match self {
            Toolchain::Rustup => Command::new("cargo"),
            Toolchain::Debian => Command::new("/usr/bin/cargo"),
        };
        clean(&mut cargo);
        if self == Toolchain::Debian {
            let path = std::env::var("PATH").unwrap_or_default();
            cargo.env("PATH", format!("/usr/bin:{path}"));
            cargo.env("RUSTC", "/usr/bin/rustc");
            // build-std is not stable; the packaged compiler is.
            cargo.env("RUSTC_BOOTSTRAP", "1");
            cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld");
        }
        cargo
    }

    /// What `cargo build` needs besides.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Toolchain::Rustup => &[],
            Toolchain::Debian => &["-Zbuild-std=core", "-Zbuild-std-features=compiler-builtins-mem"],
        }
    }
}

impl fmt::Display for Toolchain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Toolchain::Rustup => "rustup's toolchain",
            Toolchain::Debian => "Debian's rustc, core built from source",
        })
    }
}

fn has_rustup_target() -> bool {
    let output = clean(&mut Command::new("rustc"))
        .current_dir(crate::workspace())
        .args(["--print", "target-libdir", "--target", TARGET])
        .stderr(Stdio::null())
        .output();
    output.is_ok_and(|output| {
        output.status.success() && Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir()
    })
}

fn add_rustup_target() -> bool {
    clean(&mut Command::new("rustup"))
        .current_dir(crate::workspace())
        .args(["target", "add", TARGET])
        .env("RUSTUP_MAX_RETRIES", "0")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output();
    output.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
