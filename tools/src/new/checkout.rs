//! The repository that this program was built in, as the source of crates for a new project.
//!
//! A program that was installed from packages has none: its projects take the crates from the registry.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use toml::{Table, Value};

use crate::images::OF_BOARDS;
use crate::images::support::project;

/// The manifest of the repository, if the program was built there.
fn manifest() -> Option<(PathBuf, Table)> {
    let manifest = project::path("Cargo.toml");
    let table: Table = fs::read_to_string(&manifest).ok()?.parse().ok()?;
    let is_repository = table.get("workspace")?.get("dependencies")?.get("ecss-can")?.get("path").is_some();
    is_repository.then_some((manifest.parent()?.to_owned(), table))
}

/// Returns the configuration of cargo for a project with these manifests: crates of the repository by their paths, and this program
/// for the test of the flight. `None`: the program was installed from packages.
///
/// # Errors
/// When a manifest is not TOML.
pub(super) fn configuration(manifests: &[String]) -> anyhow::Result<Option<String>> {
    let Some((root, repository)) = manifest() else { return Ok(None) };
    // The project may change its board.
    let mut names: BTreeSet<String> = OF_BOARDS.map(str::to_owned).into();
    for manifest in manifests {
        names.extend(dependencies(&manifest.parse().context("a manifest of the new project")?));
    }
    let crates = repository["workspace"]["dependencies"].as_table().into_iter().flatten();
    let mut patch = Table::new();
    for (key, dependency) in crates {
        let name = dependency.get("package").and_then(Value::as_str).unwrap_or(key);
        let Some(path) = dependency.get("path").and_then(Value::as_str) else { continue };
        if names.contains(name) {
            let path = Value::from(root.join(path).display().to_string());
            patch.insert(name.to_owned(), Table::from_iter([("path".to_owned(), path)]).into());
        }
    }
    let program = env::current_exe().context("the path of this program")?;
    let program = Table::from_iter([("ECSS_CAN".to_owned(), program.display().to_string().into())]);
    let patch = Table::from_iter([("crates-io".to_owned(), patch.into())]);
    let configuration =
        Table::from_iter([("env".to_owned(), program.into()), ("patch".to_owned(), patch.into())]);
    let reason = "# This project was made by a program that was built in a repository. It uses the crates of that repository, and its\n\
                  # test of the flight uses that program.\n";
    Ok(Some(format!("{reason}{configuration}")))
}

/// Returns the packages that a manifest depends on.
pub(super) fn dependencies(manifest: &Table) -> BTreeSet<String> {
    let targets = manifest.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    let tables = std::iter::once(manifest).chain(targets.filter_map(Value::as_table));
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let all = tables.flat_map(|table| kinds.iter().filter_map(|kind| table.get(*kind)?.as_table()));
    let name = |(key, value): (&String, &Value)| {
        value.get("package").and_then(Value::as_str).unwrap_or(key).to_owned()
    };
    all.flatten().map(name).collect()
}

/// Returns the path of `to` from the folder `from`; both are absolute.
pub(super) fn relative(to: &Path, from: &Path) -> PathBuf {
    let shared = to.components().zip(from.components()).take_while(|(left, right)| left == right).count();
    let up = from.components().skip(shared).map(|_| Path::new(".."));
    up.chain(to.components().skip(shared).map(|part| Path::new(part.as_os_str()))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_of_all_kinds_of_dependencies_are_found() {
        let manifest = r#"
            [dependencies]
            a = "1"
            [target.'cfg(any())'.dependencies]
            board = { package = "b", path = "../b" }
            [build-dependencies]
            c = "1"
        "#;
        let names = dependencies(&manifest.parse().unwrap());
        assert_eq!(names.into_iter().collect::<Vec<_>>(), ["a", "b", "c"]);
    }

    #[test]
    fn configuration_names_used_crates_of_this_repository_only() {
        let manifest = "[dependencies]\necss-can = \"0.2\"\ndefmt = \"1\"\n".to_owned();
        let text = configuration(&[manifest]).unwrap().expect("the tests run in the repository");
        let parsed: Table = text.parse().unwrap();
        let patch = parsed["patch"]["crates-io"].as_table().unwrap();
        assert_eq!(patch.keys().collect::<Vec<_>>(), ["ecss-can", "ecss-can-memory", "ecss-can-stm32f4"]);
        assert!(Path::new(patch["ecss-can"]["path"].as_str().unwrap()).join("Cargo.toml").is_file());
    }

    #[test]
    fn relative_paths_lead_from_one_folder_to_another() {
        let path = |to, from| relative(Path::new(to), Path::new(from)).display().to_string();
        assert_eq!(path("/a/h405", "/a/heater"), "../h405");
        assert_eq!(path("/b/h405", "/a/heater"), "../../b/h405");
        assert_eq!(path("/a/ground/heater", "/a/ground"), "heater");
    }
}
