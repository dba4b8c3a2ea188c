//! Documentation of each published package alone, as docs.rs builds it: by the settings in its manifest.

use std::time::Instant;

use anyhow::{Context, ensure};
use cargo_metadata::Package;
use ecss_can_cli::images::support::{output, project};
use ecss_can_cli::images::{TARGET, document, host_cargo};
use serde::Deserialize;

use super::BUILT;

/// `[package.metadata.docs.rs]` of a manifest.
#[derive(Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct Settings {
    /// All features of the package.
    pub all_features: bool,
    /// Features beside the default ones.
    pub features: Vec<String>,
    /// `None`: the computer that builds the documentation.
    default_target: Option<String>,
    /// Further targets.
    targets: Option<Vec<String>>,
}

/// Writes the documentation of each package, without that of its dependencies. Warnings are errors.
///
/// # Errors
/// When a manifest has other settings than these, or the documentation of a package has a warning.
pub fn check(packages: &[&Package]) -> anyhow::Result<()> {
    for package in packages {
        let begin = Instant::now();
        let name = &package.name;
        let settings = Settings::of(package)?;
        if settings.is_for_boards()? {
            document(name, &settings.features)?;
        } else {
            on_host(name, &settings)?;
        }
        output::line(format_args!("{:>6.1} s  documentation of {name}", begin.elapsed().as_secs_f64()))?;
    }
    Ok(())
}

fn on_host(package: &str, settings: &Settings) -> anyhow::Result<()> {
    let mut cargo = host_cargo();
    cargo.args(["doc", "--quiet", "--offline", "--locked", "--no-deps", "--lib", "--package", package]);
    cargo.args(settings.all_features.then_some("--all-features"));
    cargo.args(["--features", &settings.features.join(",")]);
    cargo.arg("--target-dir").arg(project::target(BUILT)).env("RUSTDOCFLAGS", "-D warnings");
    let status = cargo.current_dir(project::path("")).status().context("cannot run cargo")?;
    ensure!(status.success(), "cargo doc failed for {package} ({status}), see above");
    Ok(())
}

impl Settings {
    /// Returns the settings of a package.
    ///
    /// # Errors
    /// When the manifest has others than these.
    pub fn of(package: &Package) -> anyhow::Result<Settings> {
        let Some(given) = package.metadata.get("docs").and_then(|docs| docs.get("rs")) else {
            return Ok(Settings::default());
        };
        serde_json::from_value(given.clone())
            .with_context(|| format!("{}: package.metadata.docs.rs", package.name))
    }

    /// Returns whether the documentation is written for the target of boards, and for no other.
    ///
    /// # Errors
    /// When it is written for another target, or for several.
    pub fn is_for_boards(&self) -> anyhow::Result<bool> {
        match &self.default_target {
            None => Ok(false),
            Some(target) => {
                ensure!(target == TARGET, "default-target is {target}; allowed is {TARGET}");
                let is_only = self.targets.as_ref().is_some_and(Vec::is_empty);
                ensure!(is_only, "targets must be [], or docs.rs builds for computers too");
                ensure!(!self.all_features, "all-features contains a chip, and each image has one");
                Ok(true)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::{metadata, published};

    /// Given the published packages, then chip support, runtime and boards are documented for boards, and others for computers.
    #[test]
    fn crates_of_boards_are_documented_for_their_target() {
        let metadata = metadata().unwrap();
        let packages = published(&metadata);
        let is_for_boards = |package: &Package| Settings::of(package).unwrap().is_for_boards().unwrap();
        let of_boards = packages.iter().filter(|package| is_for_boards(package));
        let names: Vec<&str> = of_boards.map(|package| package.name.as_str()).collect();
        let expected = ["nucleo-f446re", "pyboard-v11", "runtime", "stm32f4", "stm32f4discovery"];
        assert_eq!(names, expected.map(|name| format!("ecss-can-{name}")));
    }

    #[test]
    fn settings_that_mean_another_build_are_refused() {
        let of_boards = Settings { default_target: Some(TARGET.into()), ..Settings::default() };
        for (wrong, fault) in [
            (
                Settings { default_target: Some("thumbv6m-none-eabi".into()), ..Settings::default() },
                "allowed is",
            ),
            (of_boards, "targets must be []"),
        ] {
            assert!(wrong.is_for_boards().unwrap_err().to_string().contains(fault), "{wrong:?}");
        }
        let unknown = serde_json::json!({ "rustdoc-args": ["--cfg", "docsrs"] });
        assert!(serde_json::from_value::<Settings>(unknown).is_err());
    }
}
