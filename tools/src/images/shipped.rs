//! *Shipped sources*: the sources of the images that this program contains.
//!
//! They are the files of `tools/shipped`: links to the manifests, build scripts and programs of the images, and to `Cargo.toml`,
//! `Cargo.lock` and `rust-toolchain.toml` of the repository. [`write`] makes a workspace of them in which each crate of this
//! project comes from the registry instead of a folder.

use std::path::Path;

use toml::{Table, Value};

use crate::images::Error;
use crate::images::manifest::{parse_text, store, strings, table};

/// Packages of the images: folders below `firmware`.
pub(in crate::images) const MEMBERS: [&str; 4] = ["master", "slave", "minimal", "checks"];

/// `Cargo.toml` of the repository: profile of the images, and versions of their dependencies.
pub(in crate::images) const WORKSPACE: &str = include_str!("../../shipped/workspace.toml");
/// `Cargo.toml` of the master.
pub(in crate::images) const MASTER: &str = include_str!("../../shipped/master/manifest.toml");

/// Manifests of [`MEMBERS`].
const MANIFESTS: [&str; 4] = [
    MASTER,
    include_str!("../../shipped/slave/manifest.toml"),
    include_str!("../../shipped/minimal/manifest.toml"),
    include_str!("../../shipped/checks/manifest.toml"),
];

/// A file and its text.
macro_rules! files {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_str!(concat!("../../shipped/", $path)))),*]
    };
}

/// Files that are written unchanged: those of images below `firmware`.
const OF_IMAGES: [(&str, &str); 16] = files![
    "master/build.rs",
    "master/src/app.rs",
    "master/src/host.rs",
    "master/src/main.rs",
    "slave/build.rs",
    "slave/src/app.rs",
    "slave/src/host.rs",
    "slave/src/main.rs",
    "minimal/build.rs",
    "minimal/src/app.rs",
    "minimal/src/host.rs",
    "minimal/src/main.rs",
    "checks/build.rs",
    "checks/src/bin/parameter_store.rs",
    "checks/src/bin/pulse.rs",
    "checks/src/bin/selftest.rs",
];
const OF_ROOT: [(&str, &str); 2] = files!["Cargo.lock", "rust-toolchain.toml"];

/// Writes the workspace to the folder `root`.
///
/// # Errors
/// When a file cannot be written.
pub(in crate::images) fn write(root: &Path) -> Result<(), Error> {
    let workspace = parse_text(WORKSPACE, Path::new("shipped/workspace.toml"))?;
    for (name, text) in OF_ROOT {
        // Cargo adds the source of each crate of this project to the lock.
        if !root.join(name).is_file() {
            store(&root.join(name), text)?;
        }
    }
    for (path, text) in OF_IMAGES {
        store(&root.join("firmware").join(path), text)?;
    }
    for (member, text) in MEMBERS.into_iter().zip(MANIFESTS) {
        let manifest = member_manifest(parse_text(text, Path::new(member))?, &workspace);
        store(&root.join("firmware").join(member).join("Cargo.toml"), &manifest.to_string())?;
    }
    store(&root.join("Cargo.toml"), &root_manifest(workspace).to_string())
}

/// The manifest of the workspace: that of the repository with the images alone, and crates from the registry.
fn root_manifest(mut root: Table) -> Table {
    let workspace = table(&mut root, "workspace");
    workspace.remove("default-members");
    workspace.insert("members".into(), strings(MEMBERS.map(|member| format!("firmware/{member}"))));
    let dependencies = table(workspace, "dependencies");
    // Packages without a version are not published. No image has one.
    dependencies.retain(|_, dependency| dependency.is_str() || dependency.get("version").is_some());
    for dependency in dependencies.iter_mut().filter_map(|(_, dependency)| dependency.as_table_mut()) {
        dependency.remove("path");
    }
    keep_profiles_of_images(&mut root);
    root
}

/// Removes the profiles that name packages without images.
pub(in crate::images) fn keep_profiles_of_images(root: &mut Table) {
    table(root, "profile").retain(|name, _| ["firmware", "release"].contains(&name));
}

/// The manifest of an image with versions instead of paths, by the dependencies of the workspace.
fn member_manifest(mut image: Table, workspace: &Table) -> Table {
    let versions = workspace.get("workspace").and_then(|workspace| workspace.get("dependencies"));
    for (_, target) in table(&mut image, "target").iter_mut() {
        let Some(Value::Table(dependencies)) = target.get_mut("dependencies") else { continue };
        for (name, dependency) in dependencies.iter_mut() {
            let Some(dependency) = dependency.as_table_mut() else { continue };
            if dependency.remove("path").is_some()
                && let Some(version) = versions.and_then(|all| all.get(name)?.get("version"))
            {
                dependency.insert("version".into(), version.clone());
            }
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;

    /// Files below a folder, relative to it.
    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
    }

    #[test]
    fn program_contains_each_file_of_the_folder() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shipped");
        let manifests = MEMBERS.map(|member| format!("{member}/manifest.toml"));
        let known = OF_IMAGES.iter().chain(&OF_ROOT).map(|(path, _)| (*path).to_owned());
        let mut known: Vec<_> = known.chain(manifests).chain(["workspace.toml".to_owned()]).collect();
        known.sort();
        let there = files(&folder);
        let mut there: Vec<_> =
            there.iter().map(|path| path.strip_prefix(&folder).unwrap().display().to_string()).collect();
        there.sort();
        assert_eq!(known, there);
    }

    /// Given the shipped sources, when they are written, then no manifest has a path, and each dependency has a version.
    #[test]
    fn written_manifests_have_versions_instead_of_paths() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path()).unwrap();
        let mut manifests: Vec<_> =
            files(folder.path()).into_iter().filter(|path| path.ends_with("Cargo.toml")).collect();
        manifests.sort();
        assert_eq!(manifests.len(), 1 + MEMBERS.len());
        for manifest in manifests {
            let text = fs::read_to_string(&manifest).unwrap();
            // Programs have the paths of their sources.
            let others = text.lines().filter(|line| !line.starts_with("path = \"src/"));
            assert!(!others.clone().any(|line| line.contains("path = ")), "{text}");
        }
        let root = fs::read_to_string(folder.path().join("Cargo.toml")).unwrap();
        let root: Table = root.parse().unwrap();
        let chip = &root["workspace"]["dependencies"]["ecss-can-stm32f4"];
        assert_eq!(chip["version"].as_str(), Some(env!("CARGO_PKG_VERSION")));
        let before = fs::metadata(folder.path().join("Cargo.toml")).unwrap().modified().unwrap();
        write(folder.path()).unwrap();
        let after = fs::metadata(folder.path().join("Cargo.toml")).unwrap().modified().unwrap();
        assert_eq!(before, after, "what is there is left as it is");
    }
}
