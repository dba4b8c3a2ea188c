//! Images of a user's package, in this workspace or in another one.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::images::board_crate::{check_chip, folders};
use crate::images::manifest::parse_text;
use crate::images::once::once;
use crate::images::shipped::WORKSPACE;
use crate::images::{Error, Job, LOG, TARGET, checkout, command_line, keep, output, target, workspace};

/// An error that stopped a build.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Its code, such as `E0382`, where the compiler gives one.
    pub code: Option<String>,
    /// Its text, as it is printed.
    pub text: String,
}

/// A package with firmware of the user's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Its `Cargo.toml`, or that of its workspace.
    pub manifest: PathBuf,
}

impl Package {
    /// A package of this workspace.
    pub fn of_workspace(name: &str) -> Package {
        Package { name: name.into(), manifest: workspace().join("Cargo.toml") }
    }

    /// Returns the packages of a manifest that have images: its own package, or without one the members of the workspace that
    /// depend on `cortex-m-rt`.
    ///
    /// # Errors
    /// When cargo cannot read the manifest.
    pub fn of_manifest(manifest: &Path) -> Result<Vec<Package>, Error> {
        let metadata = target::metadata(manifest)?;
        let names = of_metadata(&metadata, manifest).into_iter();
        Ok(names.map(|name| Package { name, manifest: manifest.to_owned() }).collect())
    }

    /// Builds its images as the shipped images are built: same toolchain, same profile of cargo. `board` is a board among its features;
    /// `None`: its manifest names the board. Returns the ELF file of each of its programs: in the folder `firmware` of
    /// its target directory, or there in a folder that has the name of the feature.
    ///
    /// # Errors
    /// See [`Error`]; each says what to do.
    pub fn build<'a>(&self, board: impl Into<Option<&'a str>>) -> Result<Vec<PathBuf>, Error> {
        self.build_with(board.into(), &[], LOG)
    }

    /// As [`Package::build`], with these features and this filter of the log.
    ///
    /// # Errors
    /// See [`Error`]; each says what to do.
    pub fn build_with(
        &self,
        board: Option<&str>,
        features: &[String],
        log: &str,
    ) -> Result<Vec<PathBuf>, Error> {
        let build = || {
            self.run(board, features, log, "json-render-diagnostics", |cargo, to| {
                let (line, output) = output(cargo)?;
                if !output.status.success() {
                    return Err(Error::Failed(line, output.status));
                }
                let built = messages(&output)
                    .filter_map(|message| Some(PathBuf::from(message.get("executable")?.as_str()?)));
                built.map(|elf| keep(&elf, to)).collect()
            })
        };
        let (name, manifest) = (&self.name, self.manifest.display());
        once(format!("{name} of {manifest} for {board:?} with {features:?} {log}"), build)
    }

    /// Builds it and returns each error of the compiler. If the build fails without one, as in a build script, that is
    /// the only error.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn refusals<'a>(&self, board: impl Into<Option<&'a str>>) -> Result<Vec<Refusal>, Error> {
        self.run(board.into(), &[], LOG, "json", |cargo, _| {
            let line = command_line(cargo);
            let output = cargo.output().map_err(|error| Error::Spawn(line, error))?;
            let errors = messages(&output).filter_map(|message| {
                let message = message.get("message").filter(|message| message["level"] == "error")?;
                let code = message["code"]["code"].as_str().map(str::to_owned);
                Some(Refusal { code, text: message["rendered"].as_str()?.to_owned() })
            });
            let mut errors: Vec<Refusal> = errors.collect();
            if errors.is_empty() && !output.status.success() {
                let text = String::from_utf8_lossy(&output.stderr).into_owned();
                errors.push(Refusal { code: None, text });
            }
            Ok(errors)
        })
    }

    fn run<T>(
        &self,
        board: Option<&str>,
        features: &[String],
        log: &str,
        format: &str,
        run: impl FnOnce(&mut Command, &Path) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let manifest =
            self.manifest.canonicalize().map_err(|error| Error::Directory(self.manifest.clone(), error))?;
        let root = workspace();
        let is_ours =
            checkout::is_there() && root.canonicalize().is_ok_and(|root| manifest.starts_with(root));
        let home = if is_ours { &root } else { manifest.parent().unwrap_or(Path::new("/")) };
        let of_board = board.map_or(String::new(), |board| format!(" for {board}"));
        let task = format!("build {}{of_board}", self.name);
        let job = Job { home, prepare: &|| Ok(()), task, log, is_locked: is_ours };
        let mut what = vec!["--package".to_owned(), self.name.clone()];
        for feature in board.into_iter().chain(features.iter().map(String::as_str)) {
            let feature = if is_ours { format!("{}/{feature}", self.name) } else { feature.to_owned() };
            what.extend(["--features".to_owned(), feature]);
        }
        what.push(format!("--message-format={format}"));
        if !is_ours {
            what.extend(profile()?.into_iter().flat_map(|setting| ["--config".to_owned(), setting]));
        }
        let target_dir = job.target_dir();
        let own = if is_ours {
            target::target()
        } else {
            let metadata = target::metadata(&manifest)?;
            folders(&metadata, &self.name).iter().try_for_each(|folder| check_chip(folder))?;
            target::of_workspace(&metadata, &manifest)?
        };
        let to = own.join("firmware").join(board.unwrap_or_default());
        job.run(&["build"], &what, &[], |cargo| {
            self.forget_namesake(&target_dir, home)?;
            run(cargo, &to)
        })
    }

    /// Makes cargo rebuild this package if it has built one of the same name in another folder before. Cargo does not
    /// distinguish them, because both are the root of their workspace.
    fn forget_namesake(&self, target_dir: &Path, home: &Path) -> Result<(), Error> {
        let unusable = |error| Error::Directory(target_dir.to_owned(), error);
        let note = target_dir.join(format!("{}.home", self.name));
        let home = home.display().to_string();
        if fs::read_to_string(&note).is_ok_and(|before| before == home) {
            return Ok(());
        }
        // The package itself, and its build script on the host.
        for folder in [target_dir.join(TARGET).join("firmware"), target_dir.join("firmware")] {
            let Ok(built) = fs::read_dir(folder.join(".fingerprint")) else { continue };
            for entry in built {
                let entry = entry.map_err(unusable)?;
                if entry.file_name().to_string_lossy().starts_with(&format!("{}-", self.name)) {
                    fs::remove_dir_all(entry.path()).map_err(unusable)?;
                }
            }
        }
        fs::write(&note, home).map_err(unusable)
    }
}

/// Returns the names of the packages with images, from the output of `cargo metadata` for `manifest`.
fn of_metadata(metadata: &Value, manifest: &Path) -> Vec<String> {
    let packages = metadata["packages"].as_array().map(Vec::as_slice).unwrap_or_default();
    let names = |packages: &mut dyn Iterator<Item = &Value>| -> Vec<String> {
        packages.filter_map(|package| Some(package["name"].as_str()?.to_owned())).collect()
    };
    let manifest = manifest.canonicalize().unwrap_or_else(|_| manifest.to_owned());
    let is_own = |package: &&Value| {
        let path = package["manifest_path"].as_str().map(Path::new);
        path.and_then(|path| path.canonicalize().ok()).is_some_and(|path| path == manifest)
    };
    let own = names(&mut packages.iter().filter(is_own));
    if !own.is_empty() {
        return own;
    }
    let has_image = |package: &&Value| {
        let all = package["dependencies"].as_array().map(Vec::as_slice).unwrap_or_default();
        all.iter().any(|dependency| dependency["name"] == "cortex-m-rt")
    };
    names(&mut packages.iter().filter(has_image))
}

/// Returns the messages of cargo, one per line.
fn messages(output: &Output) -> impl Iterator<Item = Value> {
    output.stdout.split(|byte| *byte == b'\n').filter_map(|line| serde_json::from_slice(line).ok())
}

/// The profile `firmware` of this workspace as settings for `cargo --config`: another workspace has none.
fn profile() -> Result<Vec<String>, Error> {
    let parsed = parse_text(WORKSPACE, Path::new("Cargo.toml"))?;
    let profile = parsed.get("profile").and_then(|profiles| profiles.get("firmware"));
    let mut settings = Vec::new();
    if let Some(profile) = profile {
        flatten("profile.firmware", profile, &mut settings);
    }
    // Cargo warns of packages that it does not find, and the master is an image of this workspace.
    settings.retain(|setting| !setting.starts_with("profile.firmware.package.master."));
    Ok(settings)
}

/// Adds each value with its dotted key.
fn flatten(key: &str, value: &toml::Value, settings: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(name, value)| flatten(&format!("{key}.{name}"), value, settings));
        }
        toml::Value::String(text) => settings.push(format!("{key}={text:?}")),
        toml::Value::Integer(number) => settings.push(format!("{key}={number}")),
        toml::Value::Boolean(on) => settings.push(format!("{key}={on}")),
        // A profile has no others.
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_becomes_settings_for_another_workspace() {
        let settings = profile().unwrap();
        assert!(settings.contains(&"profile.firmware.inherits=\"release\"".to_owned()), "{settings:?}");
        assert!(settings.contains(&"profile.firmware.opt-level=\"z\"".to_owned()), "{settings:?}");
        assert!(!settings.iter().any(|setting| setting.contains("package.master")), "{settings:?}");
    }
}
