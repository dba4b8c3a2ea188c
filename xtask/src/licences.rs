//! `cargo xtask licences`: licences, versions and sources of all packages, by cargo-deny and `deny.toml`.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};
use clap::Args;

use support::{output, project};

const PROGRAM: &str = "cargo-deny";
const VERSION: &str = "0.20.2";

/// Command line of `licences`.
#[derive(Args, Debug)]
pub struct Options {
    /// Build cargo-deny where it is missing: about a minute on two cores, from the registry of crates
    #[arg(long)]
    install: bool,

    /// Where cargo-deny is looked for when it is not in PATH, and installed [default: target/tools] of the project
    #[arg(long, value_name = "DIR", default_value_os_t = project::path("target/tools"), hide_default_value = true)]
    root: PathBuf,
}

/// Checks all packages of `Cargo.lock`, also those of targets that are not built here.
///
/// # Errors
/// When cargo-deny is missing, or refuses a package.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let status = Command::new(find(options)?)
        .args(["--locked", "check", "--hide-inclusion-graph", "licenses", "bans", "sources"])
        .current_dir(project::path(""))
        .status()
        .with_context(|| format!("cannot run {PROGRAM}"))?;
    ensure!(status.success(), "{PROGRAM} refuses a package, see above; deny.toml says what is allowed");
    Ok(())
}

/// The program in PATH, else the installed one.
fn find(options: &Options) -> anyhow::Result<PathBuf> {
    let installed = options.root.join("bin").join(PROGRAM);
    for program in [Path::new(PROGRAM), &installed] {
        if is_there(program)? {
            return Ok(program.into());
        }
    }
    if !options.install {
        bail!(
            "{PROGRAM} is neither in PATH nor in {}: `cargo xtask licences --install` builds it there in about a minute, \
             `cargo install {PROGRAM} --locked` for all projects",
            project::shown(&options.root)
        );
    }
    install(&options.root)?;
    Ok(installed)
}

fn is_there(program: &Path) -> anyhow::Result<bool> {
    let version = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    match version {
        Ok(status) => Ok(status.success()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("cannot run {}", program.display())),
    }
}

/// Without optimisation: the check takes a second either way, and the build 78 s of CPU time instead of 202 s.
fn install(root: &Path) -> anyhow::Result<()> {
    output::note(format_args!(
        "building {PROGRAM} {VERSION} in {}, about a minute on two cores",
        project::shown(root)
    ));
    let mut cargo = Command::new("cargo");
    firmware_images::clean(&mut cargo)
        .args(["install", PROGRAM, "--version", VERSION, "--locked", "--debug", "--no-default-features"])
        .arg("--root")
        .arg(root)
        .env("CARGO_PROFILE_DEV_DEBUG", "0")
        .current_dir(project::path(""));
    let status = cargo.status().context("cannot run cargo")?;
    ensure!(status.success(), "cargo install {PROGRAM} failed ({status})");
    Ok(())
}
