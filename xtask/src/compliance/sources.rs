//! The sources that `cargo test` compiles: targets of the workspace, and the modules that they lead to.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use cargo_metadata::MetadataCommand;
use ecss_can_cli::images::support::project::path;

use super::tags::{self, Reading, Tag, Target};

/// Where a target begins.
pub struct Root {
    path: PathBuf,
    is_tested: bool,
    target: Target,
}

/// A target whose first file is `path`; `is_tested`: `cargo test` runs its tests.
pub fn root(path: &Path, is_tested: bool, target: Target) -> Root {
    Root { path: path.to_owned(), is_tested, target }
}

/// Tags of all sources of the workspace in `folder`.
///
/// # Errors
/// A source that cannot be read or is not Rust.
pub fn read_all(folder: &Path) -> anyhow::Result<Vec<Tag>> {
    let metadata = MetadataCommand::new()
        .manifest_path(folder.join("Cargo.toml"))
        .no_deps()
        .exec()
        .context("cargo does not tell the packages of the workspace")?;
    let mut roots = Vec::new();
    for package in &metadata.packages {
        let place = metadata.workspace_default_members.iter().position(|member| *member == package.id);
        let name = package.name.to_string();
        let own =
            package.manifest_path.parent().map(|folder| shown(folder.as_std_path())).unwrap_or_default();
        roots.extend(package.targets.iter().map(|target| {
            let options = options(target);
            let own = Target { package: name.clone(), folder: own.clone(), options, place };
            root(target.src_path.as_std_path(), target.test, own)
        }));
    }
    read(roots, folder)
}

/// Options of `cargo test` that select a target of its package.
fn options(target: &cargo_metadata::Target) -> Vec<String> {
    let named = |option: &str| vec![option.to_owned(), target.name.clone()];
    match () {
        () if target.is_bin() => named("--bin"),
        () if target.is_test() => named("--test"),
        () if target.is_example() => named("--example"),
        () if target.is_bench() => named("--bench"),
        () => vec!["--lib".to_owned()],
    }
}

/// Tags of the sources that these roots lead to, and of sources in `folder` that none of them leads to. A file that is
/// tested by one target is tested.
///
/// # Errors
/// A source that cannot be read or is not Rust.
pub fn read(mut roots: Vec<Root>, folder: &Path) -> anyhow::Result<Vec<Tag>> {
    roots.sort_by_key(|root| !root.is_tested);
    let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
    for root in roots {
        let mut files = vec![(root.path.clone(), Vec::new())];
        while let Some((file, around)) = files.pop() {
            let file = fs::canonicalize(&file).with_context(|| format!("cannot find {}", file.display()))?;
            if !seen.insert(file.clone()) {
                continue;
            }
            let is_root = around.is_empty();
            let reading = Reading {
                file: shown(&file),
                is_tested: root.is_tested,
                target: root.target.clone(),
                modules: around,
            };
            let source = tags::read(&text(&file)?, &reading)?;
            found.extend(source.tags);
            let modules = if is_root || file.ends_with("mod.rs") { file.parent() } else { None };
            let modules = modules.map_or_else(|| file.with_extension(""), Path::to_owned);
            let inner = source.modules.iter();
            files.extend(inner.map(|module| (module.file(&file, &modules), module.names(&reading.modules))));
        }
    }
    for file in rust_files(folder)? {
        if seen.contains(&file) {
            continue;
        }
        let reading = Reading { file: shown(&file), ..Reading::default() };
        // Snippets that are no Rust of ours, but a tag in them would be one that nothing runs.
        let text = text(&file)?;
        if text.contains("Verifies:") {
            found.extend(tags::read(&text, &reading)?.tags);
        }
    }
    found.sort_by(|one, other| (&one.file, one.line).cmp(&(&other.file, other.line)));
    Ok(found)
}

fn text(file: &Path) -> anyhow::Result<String> {
    fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))
}

/// From the root of the repository, with slashes.
fn shown(file: &Path) -> String {
    let root = fs::canonicalize(path(".")).unwrap_or_default();
    let parts = file.strip_prefix(root).unwrap_or(file).components();
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// All Rust files in `folder` but for what is built and what is hidden.
fn rust_files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let (mut found, mut folders) = (Vec::new(), vec![fs::canonicalize(folder)?]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let entry = entry?;
            let name = entry.file_name();
            let is_ours = name != "target" && !name.to_string_lossy().starts_with('.');
            match entry.file_type()? {
                kind if kind.is_dir() && is_ours => folders.push(entry.path()),
                kind if kind.is_file() && entry.path().extension().is_some_and(|it| it == "rs") => {
                    found.push(entry.path())
                }
                _ => {}
            }
        }
    }
    Ok(found)
}
