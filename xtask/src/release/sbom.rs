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
    for image in IMAGES {
        let file = format!("{image}.cdx.json");
        let package = tree.join("firmware").join(image);
        let mut cyclonedx = Command::new(&tool);
        cyclonedx.args(["cyclonedx", "-qq", "--format", "json", "--spec-version", "1.5", "--no-build-deps"]);
        cyclonedx.args(["--target", TARGET, "--features", Board::DEFAULT]);
        cyclonedx.args(["--override-filename", file.trim_end_matches(".json")]).current_dir(&package);
        let status = cyclonedx.status().with_context(|| format!("cannot run {}", CYCLONEDX.program))?;
        ensure!(status.success(), "{} failed for {image} ({status})", CYCLONEDX.program);
        let to = folder.join(&file);
        fs::copy(package.join(&file), &to).with_context(|| format!("cannot write {}", to.display()))?;
        output::line(to.display())?;
    }
    Ok(())
}
