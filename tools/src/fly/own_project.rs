//! What a flight takes from the project of the user: its mission file, its package, and the board that this is built for.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Context;
use can_twin::description::{self, Description};
use serde_json::Value;

use super::mission_file;
use super::options::Options;
use super::own::{Build, Printed, SheetOf, add_image};
use crate::images::support::board::{Board, Profile};
use crate::images::support::misuse::Misuse;
use crate::images::support::node::MASTER;
use crate::images::support::output;
use crate::images::support::project;
use crate::images::{Package, TARGET, host_cargo};

/// Name of a mission file that is found beside a Cargo.toml.
const MISSION: &str = "mission.toml";

/// Begin of the names of the packages of this project.
const FAMILY: &str = "ecss-can-";

/// Target directory of the user's, which other commands of cargo do not get.
const TARGET_DIRECTORY: &str = "CARGO_TARGET_DIR";

/// Support of the chip: a package that depends on it has firmware.
const CHIP: &str = "ecss-can-stm32f4";

/// Completes options by the mission file, or by the package of the project. `given`: fields of the options that the user gave.
///
/// # Errors
/// When the mission file is wrong, a package does not exist, or its data sheet cannot be made.
pub fn complete(options: &mut Options, given: &BTreeSet<String>) -> anyhow::Result<()> {
    let manifest = project::manifest(options.manifest_path.as_deref());
    let manifest = if options.manifest_path.is_some() || options.package.is_some() {
        Some(manifest.map_err(|error| Misuse::of("fly", error.to_string()))?)
    } else {
        manifest.ok()
    };
    let beside =
        manifest.as_ref().map(|manifest| manifest.with_file_name(MISSION)).filter(|path| path.is_file());
    let file = options.file.clone().or(beside);
    let mut known = given.clone();
    if let Some(file) = &file {
        known.extend(mission_file::apply(file, options, given)?);
    }
    for build in 0..options.builds.len() {
        fit(options, build, &known)?;
    }
    let Some(manifest) = manifest else { return Ok(()) };
    let is_ours = is_below(&manifest, &project::path(""));
    let has_own = options.fleet.master.is_some() || !options.fleet.own_slaves.is_empty();
    let is_implied = file.is_none() && !has_own && !is_ours;
    if options.package.is_none() && !is_implied && (file.is_none() || is_ours) {
        return Ok(());
    }
    let metadata = metadata(&manifest)?;
    if let Some(target) = metadata["target_directory"].as_str().filter(|_| !is_ours && !given.contains("out"))
    {
        options.out = Path::new(target).join("fly");
    }
    let package = match options.package.clone() {
        Some(name) => Some(named(&metadata, &manifest, &name)?),
        None => of_manifest(&metadata, &manifest).filter(|package| is_implied && has_firmware(package)),
    };
    let Some(package) = package else { return Ok(()) };
    if !known.contains("profile") && file.is_none() {
        options.fleet.target.profile = Profile::Standard;
    }
    let name = package["name"].as_str().unwrap_or_default().to_owned();
    add(Package { name, manifest }, options)?;
    fit(options, options.builds.len() - 1, &known)
}

/// Adds a package as master or as slave, as its data sheet says.
fn add(package: Package, options: &mut Options) -> anyhow::Result<()> {
    output::note(format_args!("running {} on this computer, for its data sheet", package.name));
    let printed = Printed::by(&package)?;
    let node = if printed.is_of_master() { MASTER } else { options.node };
    let has_sheet = options.sheets.iter().any(|sheet| sheet.node == node);
    let sheet = if has_sheet { SheetOf::File } else { SheetOf::Printed(printed) };
    // Named by its package until it is built.
    add_image(&mut options.fleet, node, PathBuf::from(&package.name));
    options.builds.retain(|build| build.node != node);
    options.builds.push(Build { node, package, program: None, board: None, sheet });
    Ok(())
}

/// Chooses the board of a package: that of its manifest, or the one of the flight among its features.
fn fit(options: &mut Options, build: usize, known: &BTreeSet<String>) -> anyhow::Result<()> {
    let package = &options.builds[build].package;
    let metadata = metadata(&package.manifest)?;
    let boards = boards(named(&metadata, &package.manifest, &package.name)?, &metadata);
    match &boards[..] {
        [only] if !known.contains("board") => options.fleet.target.board = only.clone(),
        [_] => {}
        _ => {
            let flown = options.fleet.target.board.name().to_owned();
            let features = package.choice()?.features;
            options.builds[build].board = features.contains(&flown).then_some(flown);
        }
    }
    Ok(())
}

/// Returns the boards among the dependencies of a package: those with a `board.toml`.
fn boards(package: &Value, metadata: &Value) -> Vec<Board> {
    let of = |dependency: &Value| {
        let all = list(&metadata["packages"]);
        let name = dependency["name"].as_str()?;
        let found = all.iter().find(|package| package["name"] == name)?;
        let folder = Path::new(found["manifest_path"].as_str()?).parent()?;
        // The boards of this project are known by their names, wherever their packages are.
        let shipped =
            name.strip_prefix(FAMILY).filter(|name| Description::names().iter().any(|known| known == name));
        let is_board = folder.join(description::FILE).is_file();
        is_board.then(|| Board::parse(shipped.unwrap_or(folder.to_str()?)).ok()).flatten()
    };
    let mut boards: Vec<Board> = list(&package["dependencies"]).iter().filter_map(of).collect();
    boards.dedup();
    boards
}

fn has_firmware(package: &Value) -> bool {
    list(&package["dependencies"]).iter().any(|dependency| dependency["name"] == CHIP)
}

/// Returns the package whose manifest this is; `None` for that of a workspace without one.
fn of_manifest<'a>(metadata: &'a Value, manifest: &Path) -> Option<&'a Value> {
    let manifest = manifest.canonicalize().ok()?;
    let is = |package: &&Value| {
        let path = package["manifest_path"].as_str().map(Path::new);
        path.and_then(|path| path.canonicalize().ok()).is_some_and(|path| path == manifest)
    };
    list(&metadata["packages"]).iter().find(is)
}

/// Returns the package of the workspace with this name.
fn named<'a>(metadata: &'a Value, manifest: &Path, name: &str) -> Result<&'a Value, Misuse> {
    let members = list(&metadata["workspace_members"]);
    let own = || list(&metadata["packages"]).iter().filter(|package| members.contains(&package["id"]));
    own().find(|package| package["name"] == name).ok_or_else(|| {
        let names: Vec<&str> = own().filter_map(|package| package["name"].as_str()).collect();
        let cause = format!("{} has no such package; allowed are {}", manifest.display(), names.join(", "));
        Misuse::value("fly", "--package <NAME>", name, cause)
    })
}

/// Returns the output of `cargo metadata` with all dependencies of images.
fn metadata(manifest: &Path) -> anyhow::Result<Value> {
    let mut cargo = host_cargo();
    if let Some(directory) = std::env::var_os(TARGET_DIRECTORY) {
        // It may be relative to the current folder.
        cargo.env(TARGET_DIRECTORY, std::path::absolute(&directory).unwrap_or_else(|_| directory.into()));
    }
    cargo
        .args(["metadata", "--format-version", "1", "--filter-platform", TARGET, "--manifest-path"])
        .arg(manifest);
    let output = cargo.current_dir(manifest.parent().unwrap_or(Path::new("."))).output();
    let output = output.context("cannot run cargo")?;
    let complaint = String::from_utf8_lossy(&output.stderr);
    anyhow::ensure!(
        output.status.success(),
        "cargo cannot read {}: {}",
        manifest.display(),
        complaint.trim()
    );
    Ok(serde_json::from_slice(&output.stdout)?)
}

fn is_below(path: &Path, folder: &Path) -> bool {
    match (path.canonicalize(), folder.canonicalize()) {
        (Ok(path), Ok(folder)) => path.starts_with(folder),
        _ => false,
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}
