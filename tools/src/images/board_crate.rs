//! The crate of the board that images are built for.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::images::Error;

/// The crate of the board that images are built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardCrate<'a> {
    /// A board of this project, by its name. Each image has it as an optional dependency.
    Shipped(&'a str),
    /// A board of another repository, by the folder of its crate.
    Elsewhere(&'a Path),
}

impl<'a> From<&'a str> for BoardCrate<'a> {
    fn from(name: &'a str) -> Self {
        BoardCrate::Shipped(name)
    }
}

/// The folder and the package of a board's crate.
///
/// # Errors
/// When the folder does not exist, or its `Cargo.toml` names no package.
pub(crate) fn read(folder: &Path) -> Result<(PathBuf, String), Error> {
    let folder = folder.canonicalize().map_err(|error| Error::Directory(folder.to_owned(), error))?;
    let manifest = folder.join("Cargo.toml");
    let text = fs::read_to_string(&manifest).map_err(|error| Error::Directory(manifest.clone(), error))?;
    let parsed: toml::Table =
        text.parse().map_err(|error| Error::Manifest(manifest.clone(), format!("{error}")))?;
    let name = parsed.get("package").and_then(|package| package.get("name")).and_then(toml::Value::as_str);
    let name =
        name.ok_or_else(|| Error::Manifest(manifest, "no package: add [package] with a name".into()))?;
    Ok((folder, name.to_owned()))
}

/// Checks the chip of the board in `folder`, if its build script does so. Otherwise the build script of the HAL would
/// run first, which panics without naming the board.
///
/// # Errors
/// When its `Cargo.toml` names no chip, one that is not supported, or another one than its `board.toml`.
pub(in crate::images) fn check_chip(folder: &Path) -> Result<(), Error> {
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
    let manifest: toml::Table = manifest.parse().unwrap_or_default();
    let of_build = manifest.get("build-dependencies").and_then(toml::Value::as_table);
    if of_build.is_none_or(|all| !all.contains_key("ecss-can-memory")) {
        return Ok(());
    }
    let checked = ecss_can_memory::place_for(folder, None);
    checked.map(drop).map_err(|error| Error::Manifest(folder.to_owned(), error.to_string()))
}

/// Returns the dependencies of a package with the name `board`.
pub(in crate::images) fn dependencies(package: &Value) -> impl Iterator<Item = &Value> {
    let all = package["dependencies"].as_array().map(Vec::as_slice).unwrap_or_default();
    let name =
        |dependency: &Value| dependency["rename"].as_str().or(dependency["name"].as_str()) == Some("board");
    all.iter().filter(move |dependency| name(dependency))
}

/// Returns the folders of the boards of the package `name`, from the output of `cargo metadata`.
pub(in crate::images) fn folders(metadata: &Value, name: &str) -> Vec<PathBuf> {
    let packages = metadata["packages"].as_array().map(Vec::as_slice).unwrap_or_default();
    let boards = packages.iter().filter(|package| package["name"] == name).flat_map(dependencies);
    boards.filter_map(|board| board["path"].as_str()).map(PathBuf::from).collect()
}

/// Returns a name that is unique for the folder, independent of its package.
pub(in crate::images) fn unique(package: &str, folder: &Path) -> String {
    let mut hasher = DefaultHasher::new();
    folder.hash(&mut hasher);
    format!("{package}-{:016x}", hasher.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_of_one_name_in_two_folders_have_two_ids() {
        let ids = ["/a/h405", "/b/h405"].map(|folder| unique("h405", Path::new(folder)));
        assert_ne!(ids[0], ids[1]);
        // Sixteen digits of the hash: no board of this project has such a name.
        assert!(ids.iter().all(|id| id.starts_with("h405-") && id.len() == 21), "{ids:?}");
    }

    #[test]
    fn folder_without_package_is_refused_with_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let said = |folder: &Path| read(folder).unwrap_err().to_string();
        assert!(said(folder.path()).contains("Cargo.toml"), "{}", said(folder.path()));
        fs::write(folder.path().join("Cargo.toml"), "[workspace]\n").unwrap();
        assert!(said(folder.path()).contains("add [package]"), "{}", said(folder.path()));
    }
}
