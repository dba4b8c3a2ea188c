//! Third-party programs from the registry of crates.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};
use clap::Args;
use ecss_can_cli::images::support::{output, project};

/// A program with a pinned version.
pub struct Tool {
    pub program: &'static str,
    pub version: &'static str,
    /// Arguments with which it prints its version.
    pub asked: &'static [&'static str],
    /// The subcommand of `cargo xtask` that needs it.
    pub subcommand: &'static str,
    /// Duration of the build on two cores, in words.
    pub takes: &'static str,
    /// Further arguments of `cargo install`.
    pub arguments: &'static [&'static str],
}

/// Location of the program, and whether it may be built.
#[derive(Args, Debug)]
pub struct Source {
    /// Build the program that this needs where it is missing: a minute or two on two cores, from the registry of crates
    #[arg(long)]
    install: bool,

    /// Where that program is looked for when it is not in PATH, and installed [default: target/tools] of the project
    #[arg(long, value_name = "DIR", default_value_os_t = project::target("tools"), hide_default_value = true)]
    root: PathBuf,
}

impl Tool {
    /// The program in PATH, else the installed one.
    ///
    /// # Errors
    /// When it is missing and may not be built, or cannot be.
    pub fn find(&self, source: &Source) -> anyhow::Result<PathBuf> {
        let Tool { program, asked, subcommand, takes, .. } = self;
        let installed = source.root.join("bin").join(program);
        for program in [Path::new(program), &installed] {
            if is_there(program, asked)? {
                return Ok(program.into());
            }
        }
        if !source.install {
            bail!(
                "{program} is neither in PATH nor in {}: `cargo xtask {subcommand} --install` builds it there in {takes}, \
                 `cargo install {program} --locked` for all projects",
                project::shown(&source.root)
            );
        }
        self.install(&source.root)?;
        Ok(installed)
    }

    /// Installs the program without optimisation. It runs for a second in both cases, and the build takes a third of
    /// the time.
    fn install(&self, root: &Path) -> anyhow::Result<()> {
        let Tool { program, version, takes, .. } = self;
        output::note(format_args!(
            "building {program} {version} in {}, {takes} on two cores",
            project::shown(root)
        ));
        let mut cargo = Command::new("cargo");
        ecss_can_cli::images::clean(&mut cargo)
            .args(["install", program, "--version", version, "--locked", "--debug"])
            .args(self.arguments)
            .arg("--root")
            .arg(root)
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .current_dir(project::path(""));
        let status = cargo.status().context("cannot run cargo")?;
        ensure!(status.success(), "cargo install {program} failed ({status})");
        Ok(())
    }
}

fn is_there(program: &Path, asked: &[&str]) -> anyhow::Result<bool> {
    let version = Command::new(program).args(asked).stdout(Stdio::null()).stderr(Stdio::null()).status();
    match version {
        Ok(status) => Ok(status.success()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error).with_context(|| format!("cannot run {}", program.display())),
    }
}
