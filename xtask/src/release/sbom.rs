//! Bills of materials (SBOM) of the shipped images, in CycloneDX, by cargo-cyclonedx.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, ensure};
use ecss_can_cli::images::TARGET;
use ecss_can_cli::images::support::board::Board;
use ecss_can_cli::images::support::{output, project};

use super::BUILT;
use crate::mutants::copy;
use crate::tool::{Source, Tool};

const CYCLONEDX: Tool = Tool {
    program: "cargo-cyclonedx",
    version: "0.5.9",
    asked: &["cyclonedx", "--version"],
    subcommand: "release --out DIR",
    takes: "about two minutes",
    arguments: &[],
};

/// Packages of the images: folders below `firmware`.
const IMAGES: [&str; 3] = ["master", "slave", "minimal"];

/// Writes `master.cdx.json`, `slave.cdx.json` and `minimal.cdx.json` into a folder: the packages of each image for the default board.
///
/// # Errors
/// When the tool is missing or fails, or a file cannot be written.
pub fn write(source: &Source, folder: &Path) -> anyhow::Result<()> {
    let tool = CYCLONEDX.find(source)?;
    // The tool writes a file beside each manifest of the workspace.
    let tree = project::target(BUILT).join("tree");
    fs::create_dir_all(&tree).with_context(|| format!("cannot use {}", tree.display()))?;
    copy::restore(&project::path(""), &tree)?;
    let date = date()?;
    for image in IMAGES {
        let file = format!("{image}.cdx.json");
        let package = tree.join("firmware").join(image);
        let mut cyclonedx = Command::new(&tool);
        cyclonedx.args(["cyclonedx", "-qq", "--format", "json", "--spec-version", "1.5", "--no-build-deps"]);
        cyclonedx.args(["--target", TARGET, "--features", Board::DEFAULT]);
        cyclonedx.args(["--override-filename", file.trim_end_matches(".json")]).current_dir(&package);
        cyclonedx.env("SOURCE_DATE_EPOCH", &date);
        let status = cyclonedx.status().with_context(|| format!("cannot run {}", CYCLONEDX.program))?;
        ensure!(status.success(), "{} failed for {image} ({status})", CYCLONEDX.program);
        let to = folder.join(&file);
        let text = fs::read_to_string(package.join(&file)).with_context(|| format!("no {file}"))?;
        // Names of packages contain their folders: here those of the repository.
        let text = text.replace(&tree.display().to_string(), "");
        fs::write(&to, text).with_context(|| format!("cannot write {}", to.display()))?;
        output::line(to.display())?;
    }
    Ok(())
}

/// Returns the date of the current commit, in seconds since 1970: the file of a commit is the same on each computer.
fn date() -> anyhow::Result<String> {
    let mut git = Command::new("git");
    let output = git.args(["log", "-1", "--format=%ct"]).current_dir(project::path("")).output();
    let output = output.context("cannot run git")?;
    ensure!(output.status.success(), "git log failed ({})", output.status);
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
