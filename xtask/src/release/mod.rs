//! `cargo xtask release`: checks the published packages, and writes what accompanies a release.
//!
//! A *published package* is one whose manifest does not say `publish = false`. `--check` packs all of them, and runs what a new
//! user runs with these files alone. `--out DIR` writes the release notes and a bill of materials (SBOM) of each image. The tag
//! and `cargo publish` belong to the owner.

mod alone;
mod archive;
mod directory;
mod documentation;
mod family;
mod front;
mod notes;
mod sbom;
mod semver;

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, bail};
use cargo_metadata::{Metadata, MetadataCommand, Package};
use clap::Args;
use ecss_can_cli::images::support::{output, project};

use crate::tool::Source;

/// Folder below the target directory for all that this command builds.
const BUILT: &str = "published";

/// Command line of `release`.
#[derive(Args, Debug)]
#[command(group(clap::ArgGroup::new("what").required(true).multiple(true)))]
pub struct Options {
    /// Pack all published packages, check versions, contents, sizes and the interface, and use the packages as a new user does
    #[arg(long, group = "what")]
    check: bool,

    /// Write release-notes.md and an SBOM of each image to this folder
    #[arg(long, value_name = "DIR", group = "what")]
    out: Option<PathBuf>,

    #[command(flatten)]
    source: Source,
}

/// Checks, then writes.
///
/// # Errors
/// When something is wrong with a package, a tool is missing, or a file cannot be written.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let metadata = metadata()?;
    let packages = published(&metadata);
    let version = version(&packages)?;
    if options.check {
        check(&packages, &version, &options.source)?;
    }
    if let Some(out) = &options.out {
        fs::create_dir_all(out).with_context(|| format!("cannot use {}", out.display()))?;
        notes::write(&version, out)?;
        sbom::write(&options.source, out)?;
    }
    Ok(())
}

fn check(packages: &[&Package], version: &str, source: &Source) -> anyhow::Result<()> {
    let mut faults = front::faults(packages, version);
    faults.extend(family::faults(packages));
    faults.extend(notes::section(version).err().map(|error| error.to_string()));
    let archives = archive::make(packages)?;
    for archive in &archives {
        output::line(format_args!("{:<28} {:>8} bytes", archive.name, archive.bytes))?;
        faults.extend(archive.faults());
    }
    faults.iter().for_each(output::complain);
    if !faults.is_empty() {
        bail!("{} faults in the published packages; see above", faults.len());
    }
    documentation::check(packages)?;
    semver::check(packages, source)?;
    alone::check(&archives)
}

/// Returns the packages of the workspace.
fn metadata() -> anyhow::Result<Metadata> {
    let mut command = MetadataCommand::new();
    command.manifest_path(project::path("Cargo.toml")).no_deps();
    command.exec().context("cargo metadata failed")
}

/// Returns the published packages, by name.
fn published(metadata: &Metadata) -> Vec<&Package> {
    let mut packages = metadata.workspace_packages();
    packages.retain(|package| package.publish.as_ref().is_none_or(|registries| !registries.is_empty()));
    packages.sort_by(|one, other| one.name.cmp(&other.name));
    packages
}

/// Returns the version of the release: that of the first package.
fn version(packages: &[&Package]) -> anyhow::Result<String> {
    let first = packages.first().context("no package is published")?;
    Ok(first.version.to_string())
}
