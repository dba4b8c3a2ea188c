//! Comparison of the interface with the last release, by cargo-semver-checks.

use std::process::Command;

use anyhow::{Context, ensure};
use ecss_can_cli::images::support::{output, project};

use crate::tool::{Source, Tool};

const SEMVER_CHECKS: Tool = Tool {
    program: "cargo-semver-checks",
    version: "0.51.0",
    asked: &["semver-checks", "--version"],
    subcommand: "release --check",
    takes: "some minutes",
    arguments: &[],
};

/// The library of the program changes without notice, and macros have no interface that the tool can read.
const EXCLUDED: [&str; 2] = ["ecss-can-cli", "async-canopen-derive"];

/// Compares the published packages with the last tag `v*`. Without a tag it prints a notice.
///
/// # Errors
/// When the tool is missing, or a change needs a higher version than the one in the manifest.
pub fn check(source: &Source) -> anyhow::Result<()> {
    let Some(tag) = last_tag()? else {
        output::note("no tag v* yet: the interface is not compared with an earlier release");
        return Ok(());
    };
    let mut tool = Command::new(SEMVER_CHECKS.find(source)?);
    tool.args(["semver-checks", "--workspace", "--baseline-rev", &tag]);
    EXCLUDED.iter().for_each(|package| {
        tool.args(["--exclude", package]);
    });
    let status = tool.current_dir(project::path("")).status();
    let status = status.with_context(|| format!("cannot run {}", SEMVER_CHECKS.program))?;
    ensure!(status.success(), "a change since {tag} needs a higher version, see above and docs/versions.md");
    Ok(())
}

/// Returns the last tag of a version in the history of the current commit.
fn last_tag() -> anyhow::Result<Option<String>> {
    let mut git = Command::new("git");
    git.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"]).current_dir(project::path(""));
    let output = git.output().context("cannot run git")?;
    let tag = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Ok(output.status.success().then_some(tag))
}
