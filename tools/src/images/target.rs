//! The *target directory*: the folder of cargo for all that it builds, `target` unless `CARGO_TARGET_DIR` or a configuration
//! file names another one. Images are kept in its folder `firmware`.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;

use serde_json::Value;

use crate::images::environment::host_cargo;
use crate::images::{Error, checkout, output, workspace};

/// A file that cargo keeps in each target directory.
const MARK: &str = ".rustc_info.json";
const VARIABLE: &str = "CARGO_TARGET_DIR";

/// Returns the target directory for images. With a checkout it is the one that this program was built in. Otherwise it is that
/// of the user's project, and outside of a project a folder of the user's cache.
pub fn target() -> PathBuf {
    if checkout::is_there() {
        let program = env::current_exe().unwrap_or_default();
        return of_program(&program).map_or_else(|| workspace().join("target"), Path::to_path_buf);
    }
    of_project().cloned().unwrap_or_else(cache)
}

/// Returns the target directory for results of commands: that of the project in the current folder, else that of images.
pub fn results() -> PathBuf {
    of_project().cloned().unwrap_or_else(target)
}

/// The target directory of the project in the current folder. `None`: no project, or the checkout that this program was built
/// in.
fn of_project() -> Option<&'static PathBuf> {
    static PROJECT: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
        let manifest = checkout::manifest_elsewhere()?;
        let output = cargo_metadata(&manifest).stderr(Stdio::null()).output().ok()?;
        of_workspace(&serde_json::from_slice(&output.stdout).ok()?, &manifest).ok()
    });
    PROJECT.as_ref()
}

/// Folder of this program in the user's cache.
fn cache() -> PathBuf {
    let cache = env::var_os("XDG_CACHE_HOME").map(PathBuf::from).filter(|folder| folder.is_absolute());
    let cache = cache.or_else(|| Some(env::home_dir()?.join(".cache")));
    cache.unwrap_or_else(env::temp_dir).join("ecss-can")
}

/// The folder `firmware` in the target directory for images.
pub(in crate::images) fn firmware() -> PathBuf {
    target().join("firmware")
}

fn of_program(program: &Path) -> Option<&Path> {
    program.ancestors().skip(1).find(|folder| folder.join(MARK).is_file())
}

/// Returns the target directory of a workspace by its metadata; errors name `manifest`.
///
/// # Errors
/// When there is none.
pub(in crate::images) fn of_workspace(metadata: &Value, manifest: &Path) -> Result<PathBuf, Error> {
    let directory = metadata["target_directory"].as_str();
    directory
        .map(PathBuf::from)
        .ok_or_else(|| Error::Manifest(manifest.to_owned(), "no target directory".into()))
}

/// Returns the output of `cargo metadata` for a manifest, without its dependencies.
///
/// # Errors
/// When cargo cannot read the manifest.
pub(in crate::images) fn metadata(manifest: &Path) -> Result<Value, Error> {
    let (line, output) = output(&mut cargo_metadata(manifest))?;
    if !output.status.success() {
        return Err(Error::Failed(line, output.status));
    }
    serde_json::from_slice(&output.stdout)
        .map_err(|error| Error::Manifest(manifest.to_owned(), format!("{error}")))
}

/// Returns the command `cargo metadata` for a manifest.
fn cargo_metadata(manifest: &Path) -> Command {
    let mut cargo = host_cargo();
    if let Some(directory) = env::var_os(VARIABLE) {
        // It may be relative to the current folder.
        cargo.env(VARIABLE, std::path::absolute(&directory).unwrap_or_else(|_| directory.into()));
    }
    cargo.args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path"]).arg(manifest);
    cargo.current_dir(manifest.parent().unwrap_or(Path::new(".")));
    cargo
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn target_directory_is_found_from_programs_and_tests() {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine");
        for program in ["debug/tools", "debug/deps/flight-0123", "x86_64-unknown-linux-gnu/release/xtask"] {
            let program = mine.join(program);
            assert_eq!(of_program(&program), None, "an installed program");
            fs::create_dir_all(&mine).unwrap();
            fs::write(mine.join(".rustc_info.json"), "{}").unwrap();
            assert_eq!(of_program(&program), Some(&*mine));
            fs::remove_file(mine.join(".rustc_info.json")).unwrap();
        }
    }
}
