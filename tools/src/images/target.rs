//! The *target directory*: the folder of cargo for all that it builds, `target` unless `CARGO_TARGET_DIR` or a configuration
//! file names another one. Images are kept in its folder `firmware`.

use std::env;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::images::environment::host_cargo;
use crate::images::{Error, output, workspace};

/// A file that cargo keeps in each target directory.
const MARK: &str = ".rustc_info.json";
const VARIABLE: &str = "CARGO_TARGET_DIR";

/// The target directory of this workspace: the one that this program was built in.
pub fn target() -> PathBuf {
    let program = env::current_exe().unwrap_or_default();
    of_program(&program).map_or_else(|| workspace().join("target"), Path::to_path_buf)
}

/// The folder `firmware` in the target directory of this workspace.
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
    let mut cargo = host_cargo();
    if let Some(directory) = env::var_os(VARIABLE) {
        // It may be relative to the current folder.
        cargo.env(VARIABLE, std::path::absolute(&directory).unwrap_or_else(|_| directory.into()));
    }
    cargo.args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path"]).arg(manifest);
    let (line, output) = output(cargo.current_dir(manifest.parent().unwrap_or(Path::new("."))))?;
    if !output.status.success() {
        return Err(Error::Failed(line, output.status));
    }
    serde_json::from_slice(&output.stdout)
        .map_err(|error| Error::Manifest(manifest.to_owned(), format!("{error}")))
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
