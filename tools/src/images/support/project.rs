//! The project's folders, independent of the current folder.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::images::checkout;

/// `relative` below the root of the project.
pub fn path(relative: &str) -> PathBuf {
    // This package is one folder below it.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(1);
    root.unwrap_or(Path::new("")).join(relative)
}

/// `relative` below the target directory of the project in the current folder.
pub fn target(relative: &str) -> PathBuf {
    crate::images::results().join(relative)
}

/// Returns the given `Cargo.toml`, or the next one from the current folder upwards.
///
/// # Errors
/// When there is none.
pub fn manifest(given: Option<&Path>) -> anyhow::Result<PathBuf> {
    let here = std::env::current_dir().context("the current folder")?;
    if let Some(given) = given {
        let path = here.join(given);
        anyhow::ensure!(
            path.is_file(),
            "{}: no such file; give the Cargo.toml of the package",
            given.display()
        );
        return Ok(path);
    }
    checkout::next_manifest()
        .with_context(|| format!("no Cargo.toml in {} or above; give --manifest-path FILE", here.display()))
}

/// Returns the root of the repository that this program was built in. `None`: it is not there, as for an installed program.
pub fn repository() -> Option<PathBuf> {
    checkout::is_there().then(|| path(""))
}

/// Returns the next `Cargo.toml` from the current folder upwards. `None`: there is none, or it belongs to [`repository`].
pub fn own() -> Option<PathBuf> {
    checkout::manifest_elsewhere()
}

/// Formats a path without the current folder in front of it.
pub fn shown(path: &Path) -> std::path::Display<'_> {
    let here = std::env::current_dir().ok();
    here.and_then(|here| path.strip_prefix(here).ok()).filter(|rest| *rest != "").unwrap_or(path).display()
}

/// Creates a folder if it is missing, and checks that files can be written to it.
///
/// # Errors
/// The reason why they cannot.
pub fn make_writable(folder: &Path) -> io::Result<()> {
    let probe = folder.join(".writable");
    std::fs::create_dir_all(folder)?;
    std::fs::write(&probe, [])?;
    std::fs::remove_file(&probe)
}
