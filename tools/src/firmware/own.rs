//! Images of a project of the user.

use std::path::PathBuf;

use clap::Args;

use crate::images::support::board::{Board, built_names};
use crate::images::support::misuse::Misuse;
use crate::images::support::project;
use crate::images::{Choice, Error, Package};

/// Packages of the user.
#[derive(Args, Clone, Debug)]
#[group(conflicts_with = "Configuration")]
pub struct Project {
    /// Package of your own: its Cargo.toml has its board as the dependency `board`, or a feature for each of its boards [default:
    /// the package of Cargo.toml]
    #[arg(long, value_name = "NAME")]
    package: Option<String>,

    /// Cargo.toml of your package or of its workspace [default: the next one from the current folder upwards]
    #[arg(long, value_name = "FILE")]
    manifest_path: Option<PathBuf>,

    /// Features of your package, separated by commas
    #[arg(long, value_name = "FEATURES", value_delimiter = ',')]
    features: Vec<String>,
}

impl Project {
    /// Returns the packages of the user that have images. There are none in the repository of the shipped images, and outside of
    /// a project, unless an option selects one. `command` is the subcommand with these options.
    ///
    /// # Errors
    /// When the selected package or manifest does not exist, or no package has an image.
    pub fn packages(&self, command: &'static str) -> anyhow::Result<Vec<Package>> {
        let is_chosen = self.package.is_some() || self.manifest_path.is_some() || !self.features.is_empty();
        if !is_chosen && project::own().is_none() {
            return Ok(Vec::new());
        }
        let manifest = project::manifest(self.manifest_path.as_deref())?;
        if let Some(name) = &self.package {
            return Ok(vec![Package { name: name.clone(), manifest }]);
        }
        let packages = Package::of_manifest(&manifest)?;
        if packages.is_empty() {
            let text = format!(
                "{} has no package with an image: none depends on cortex-m-rt; give --package NAME, or an image of this project: \
                 master, slave or minimal",
                manifest.display()
            );
            return Err(Misuse::of(command, text).into());
        }
        Ok(packages)
    }

    /// Builds the images of a package, with this filter of the log. Returns their ELF files.
    ///
    /// # Errors
    /// When the package does not exist, has no such board, does not compile, or has no program.
    pub fn build(
        &self,
        command: &'static str,
        package: &Package,
        board: Option<&Board>,
        log: &str,
    ) -> anyhow::Result<Vec<PathBuf>> {
        let name = &package.name;
        let choice = package.choice().map_err(|error| match error {
            Error::NoPackage { .. } => anyhow::Error::from(Misuse::of(
                command,
                format!("invalid value '{name}' for '--package <NAME>': {error}"),
            )),
            error => error.into(),
        })?;
        let unknown = self.features.iter().find(|feature| !choice.features.contains(feature));
        if let Some(feature) = unknown {
            let text = format!(
                "invalid value '{feature}' for '--features <FEATURES>': the package {name} has no such feature; allowed are {}",
                choice.features.join(", ")
            );
            return Err(Misuse::of(command, text).into());
        }
        let board = feature(command, name, &choice, board)?;
        let images = package.build_with(board, &self.features, log)?;
        anyhow::ensure!(!images.is_empty(), "{name} has no program: it needs a src/main.rs");
        Ok(images)
    }
}

/// Returns the feature of a package that selects the board of `--board`, or the default one. `None`: its manifest names
/// the board.
fn feature<'a>(
    command: &'static str,
    name: &str,
    choice: &Choice,
    board: Option<&'a Board>,
) -> Result<Option<&'a str>, Misuse> {
    let has = |feature: &str| choice.features.iter().any(|known| known == feature);
    match board.map(Board::name) {
        None => Ok((!choice.is_fixed && has(Board::DEFAULT)).then_some(Board::DEFAULT)),
        Some(board) if has(board) => Ok(Some(board)),
        Some(board) => {
            let boards: Vec<_> = built_names().into_iter().filter(|board| has(board)).collect();
            let rest = if boards.is_empty() {
                "it chooses its board in Cargo.toml: leave out --board".to_owned()
            } else {
                format!("allowed are {}", boards.join(", "))
            };
            let text = format!(
                "invalid value '{board}' for '--board <BOARD>': the package {name} has no dependency {board}; {rest}"
            );
            Err(Misuse::of(command, text))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(is_fixed: bool, features: &[&str]) -> Choice {
        Choice { is_fixed, features: features.iter().map(|&name| name.to_owned()).collect() }
    }

    #[test]
    fn package_is_built_for_the_board_of_manifest_or_feature() {
        let nucleo = Board::shipped("nucleo-f446re");
        let both = ["nucleo-f446re", "pyboard-v11"];
        for (is_fixed, features, board, expected) in [
            (true, &[][..], None, None),
            (true, &["pyboard-v11"], None, None),
            (false, &["fast"], None, None),
            (false, &both, None, Some("pyboard-v11")),
            (false, &both, Some(&nucleo), Some("nucleo-f446re")),
        ] {
            let choice = choice(is_fixed, features);
            assert_eq!(feature("build", "heater", &choice, board), Ok(expected), "{features:?} {board:?}");
        }
        let choice = choice(false, &["pyboard-v11"]);
        let error = feature("build", "heater", &choice, Some(&nucleo)).unwrap_err().to_string();
        assert!(error.ends_with("has no dependency nucleo-f446re; allowed are pyboard-v11"), "{error}");
    }
}
