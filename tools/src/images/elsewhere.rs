//! Images of this project for a board of another repository, built in a generated workspace.
//!
//! An image of this project has its boards as optional dependencies. A board elsewhere cannot be one of them, so a
//! small workspace in the target directory, `firmware/elsewhere`, has a package for each image. The package is the
//! shipped manifest with the crate of the board as its only board, and with paths to the shipped sources: the code of
//! the image is unchanged.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::images::manifest::{parse, store, strings, table, text};
use crate::images::shipped::{MEMBERS, keep_profiles_of_images};
use crate::images::sources::Sources;
use crate::images::{Error, board_crate, target};

/// Crates that the crate of a board depends on.
pub(crate) const OF_BOARDS: [&str; 2] = ["ecss-can-stm32f4", "ecss-can-memory"];

/// A board of another repository.
pub(in crate::images) struct Elsewhere {
    /// Folder of its crate, absolute.
    folder: PathBuf,
    /// Name of its package.
    pub(in crate::images) package: String,
}

impl Elsewhere {
    /// The board whose crate is in `folder`.
    ///
    /// # Errors
    /// When the folder has no usable `Cargo.toml`, or that names no usable chip.
    pub(in crate::images) fn of(folder: &Path) -> Result<Elsewhere, Error> {
        let (folder, package) = board_crate::read(folder)?;
        board_crate::check_chip(&folder)?;
        Ok(Elsewhere { folder, package })
    }

    /// Its name in folders: that of its package, and a hash of its path.
    pub(in crate::images) fn id(&self) -> String {
        board_crate::unique(&self.package, &self.folder)
    }

    /// Folder of the workspace.
    pub(in crate::images) fn home(&self) -> PathBuf {
        target::firmware().join("elsewhere").join(self.id())
    }

    /// Writes the workspace.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub(in crate::images) fn write(&self) -> Result<(), Error> {
        let (root, home) = (Sources::get().root(), self.home());
        let shipped = parse(&root.join("Cargo.toml"))?;
        let mut boards = Vec::new();
        for member in MEMBERS {
            let (from, to) = (root.join("firmware").join(member), home.join(member));
            let image = parse(&from.join("Cargo.toml"))?;
            boards.extend(optional_dependencies(&image));
            store(&to.join("Cargo.toml"), &member_manifest(image, &from, self).to_string())?;
            // A copy, because cargo searches files named by a build script in the folder of the package.
            store(&to.join("build.rs"), &text(&from.join("build.rs"))?)?;
        }
        boards.sort();
        boards.dedup();
        let mut manifest = root_manifest(shipped, root, &boards);
        patch(&mut manifest);
        store(&home.join("Cargo.toml"), &manifest.to_string())?;
        store(&home.join("Cargo.lock"), &text(&root.join("Cargo.lock"))?)?;
        // The toolchain of this project, wherever the workspace is.
        store(&home.join("rust-toolchain.toml"), &text(&root.join("rust-toolchain.toml"))?)
    }
}

/// The manifest of the generated workspace: dependencies, package, lints and profiles of images of the shipped one,
/// whose root is `root`. `boards` are the features that the sources test and the generated packages do not have.
fn root_manifest(mut shipped: Table, root: &Path, boards: &[String]) -> Table {
    let workspace = table(&mut shipped, "workspace");
    workspace.remove("default-members");
    workspace.insert("members".into(), strings(MEMBERS));
    make_absolute(table(workspace, "dependencies"), root);
    let names: Vec<String> = boards.iter().map(|board| format!("{board:?}")).collect();
    let known = strings([format!("cfg(feature, values({}))", names.join(", "))]);
    let lint = Table::from_iter([("level".to_owned(), "warn".into()), ("check-cfg".to_owned(), known)]);
    table(table(workspace, "lints"), "rust").insert("unexpected_cfgs".into(), lint.into());
    keep_profiles_of_images(&mut shipped);
    shipped
}

/// Lets the crate of a board that names crates by version use those of the workspace, where these have a path.
fn patch(manifest: &mut Table) {
    let dependencies = table(table(manifest, "workspace"), "dependencies").clone();
    for name in OF_BOARDS {
        if let Some(path) = dependencies.get(name).and_then(|dependency| dependency.get("path")) {
            table(table(table(manifest, "patch"), "crates-io"), name).insert("path".into(), path.clone());
        }
    }
}

/// The manifest of a generated package: that of the image in `folder`, for one board.
fn member_manifest(mut image: Table, folder: &Path, board: &Elsewhere) -> Table {
    let name = image["package"]["name"].as_str().unwrap_or_default().to_owned();
    let programs = match image.remove("bin") {
        Some(Value::Array(programs)) => programs,
        _ => vec![Table::from_iter([("name".to_owned(), Value::from(name.clone()))]).into()],
    };
    let programs = programs.into_iter().map(|program| with_path(program, folder, &name));
    let programs: Vec<Value> = programs.collect();
    image.insert("bin".into(), programs.into());
    let library = folder.join("src/lib.rs");
    if library.is_file() {
        table(&mut image, "lib").insert("path".into(), library.display().to_string().into());
    }
    table(&mut image, "package").insert("build".into(), "build.rs".into());
    if let Some(targets) = image.get_mut("target").and_then(Value::as_table_mut) {
        for target in targets.iter_mut().filter_map(|(_, target)| target.as_table_mut()) {
            let Some(Value::Table(dependencies)) = target.get_mut("dependencies") else { continue };
            make_absolute(dependencies, folder);
            let before = dependencies.len();
            dependencies.retain(|_, dependency| !is_optional(dependency));
            if dependencies.len() < before {
                let path = board.folder.display().to_string();
                let chosen = [("package", board.package.clone()), ("path", path)];
                let chosen = chosen.map(|(key, value)| (key.to_owned(), Value::from(value)));
                dependencies.insert("board".into(), Table::from_iter(chosen).into());
            }
        }
    }
    image
}

/// A program with the absolute path of its source.
fn with_path(program: Value, folder: &Path, package: &str) -> Value {
    let Value::Table(mut program) = program else { return program };
    let name = program.get("name").and_then(Value::as_str).unwrap_or_default();
    let usual = if name == package { "src/main.rs".to_owned() } else { format!("src/bin/{name}.rs") };
    let path = program.get("path").and_then(Value::as_str).unwrap_or(&usual);
    let path = folder.join(path).display().to_string();
    program.insert("path".into(), path.into());
    program.into()
}

/// Optional dependencies for a target: the boards of an image.
fn optional_dependencies(image: &Table) -> Vec<String> {
    let targets = image.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    let dependencies = targets.filter_map(|target| target.get("dependencies")?.as_table()).flatten();
    dependencies.filter(|(_, value)| is_optional(value)).map(|(name, _)| name.clone()).collect()
}

fn is_optional(dependency: &Value) -> bool {
    dependency.get("optional").and_then(Value::as_bool) == Some(true)
}

/// Makes the paths of dependencies absolute, which are relative to `folder`.
fn make_absolute(dependencies: &mut Table, folder: &Path) {
    for (_, dependency) in dependencies.iter_mut() {
        if let Some(Value::String(path)) = dependency.get_mut("path") {
            *path = folder.join(&*path).display().to_string();
        }
    }
}

#[cfg(test)]
mod tests;
