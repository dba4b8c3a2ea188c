//! `cargo xtask licences`: licences, versions and sources of all packages, by cargo-deny and `deny.toml`.

use std::process::Command;

use anyhow::{Context, ensure};
use ecss_can_cli::images::support::project;

use crate::tool::{Source, Tool};

const DENY: Tool = Tool {
    program: "cargo-deny",
    version: "0.20.2",
    asked: &["--version"],
    subcommand: "licences",
    takes: "about a minute",
    arguments: &["--no-default-features"],
};

/// Checks all packages of `Cargo.lock`, also those of targets that are not built here.
///
/// # Errors
/// When cargo-deny is missing, or refuses a package.
pub fn run(source: &Source) -> anyhow::Result<()> {
    let status = Command::new(DENY.find(source)?)
        .args(["--locked", "check", "--hide-inclusion-graph", "licenses", "bans", "sources"])
        .current_dir(project::path(""))
        .status()
        .with_context(|| format!("cannot run {}", DENY.program))?;
    ensure!(
        status.success(),
        "{} refuses a package, see above; deny.toml says what is allowed",
        DENY.program
    );
    Ok(())
}
