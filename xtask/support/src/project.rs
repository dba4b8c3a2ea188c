//! The project's own folders, whatever folder a command is called from.

use std::io;
use std::path::{Path, PathBuf};

/// `relative` below the root of the project.
pub fn path(relative: &str) -> PathBuf {
    // This crate is two folders below it.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2);
    root.unwrap_or(Path::new("")).join(relative)
}

/// A path for people: without the current folder in front of it.
pub fn shown(path: &Path) -> std::path::Display<'_> {
    let here = std::env::current_dir().ok();
    here.and_then(|here| path.strip_prefix(here).ok()).filter(|rest| *rest != "").unwrap_or(path).display()
}

/// Makes a folder where it is missing, and makes sure that files can be written to it.
///
/// # Errors
/// Why they cannot.
pub fn make_writable(folder: &Path) -> io::Result<()> {
    let probe = folder.join(".writable");
    std::fs::create_dir_all(folder)?;
    std::fs::write(&probe, [])?;
    std::fs::remove_file(&probe)
}
