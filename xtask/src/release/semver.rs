//! Comparison of the interface with the last release, by cargo-semver-checks.

use std::process::Command;

use anyhow::{Context, ensure};
use cargo_metadata::Package;
use ecss_can_cli::images::support::{output, project};

use super::documentation::Settings;
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

/// Compares the published packages with the last tag `v*`, each with the features of its documentation. Without a tag it prints a
/// notice.
///
/// # Errors
/// When the tool is missing, or a change needs a higher version than the one in the manifest.
pub fn check(packages: &[&Package], source: &Source) -> anyhow::Result<()> {
    let Some(tag) = last_tag()? else {
        output::note("no tag v* yet: the interface is not compared with an earlier release");
        return Ok(());
    };
    let program = SEMVER_CHECKS.find(source)?;
    for package in packages.iter().filter(|package| !EXCLUDED.contains(&package.name.as_str())) {
        let name = &package.name;
        let settings = Settings::of(package)?;
        if settings.is_for_boards()? {
            output::note(format_args!("{name} is not compared: the tool cannot select a chip"));
            continue;
        }
        let mut tool = Command::new(&program);
        tool.args(["semver-checks", "--package", name, "--baseline-rev", &tag]);
        let status = tool.args(features(&settings)).current_dir(project::path("")).status();
        let status = status.with_context(|| format!("cannot run {}", SEMVER_CHECKS.program))?;
        ensure!(
            status.success(),
            "{name}: a change since {tag} needs a higher version, see above and docs/versions.md"
        );
    }
    Ok(())
}

/// Returns the arguments that select features. By default the tool enables all, also profiles of which an image has one.
fn features(settings: &Settings) -> Vec<String> {
    if settings.all_features {
        return vec!["--all-features".to_owned()];
    }
    let given = settings.features.iter().flat_map(|feature| ["--features".to_owned(), feature.clone()]);
    std::iter::once("--default-features".to_owned()).chain(given).collect()
}

/// Returns the last tag of a version in the history of the current commit.
fn last_tag() -> anyhow::Result<Option<String>> {
    let mut git = Command::new("git");
    git.args(["describe", "--tags", "--abbrev=0", "--match", "v[0-9]*"]).current_dir(project::path(""));
    let output = git.output().context("cannot run git")?;
    let tag = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    Ok(output.status.success().then_some(tag))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::{metadata, published};

    /// Given the mission, whose profiles exclude each other, then the features of its documentation are selected alone.
    #[test]
    fn features_are_those_of_the_documentation() {
        let metadata = metadata().unwrap();
        let of = |name: &str| {
            let packages = published(&metadata).into_iter();
            let package = packages.into_iter().find(|package| package.name == name).unwrap();
            features(&Settings::of(package).unwrap())
        };
        assert_eq!(of("ecss-can"), ["--all-features"]);
        assert_eq!(of("ecss-can-mission"), ["--default-features", "--features", "host"]);
        assert_eq!(of("ecss-can-eds"), ["--default-features"]);
    }
}
