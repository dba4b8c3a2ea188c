//! Work of a board's build script.

use std::path::{Path, PathBuf};
use std::{env, fs};

use crate::{Error, chip_of_board, chip_of_manifest};

/// Checks the chip of the package that is being built. For a target without operating system it also writes `memory.x` where
/// the linker finds it. Call it from the build script.
///
/// # Panics
/// Stops the build when the chip is missing, is not supported, or differs from the one in `board.toml`.
pub fn place() {
    let folder = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    let is_image = variable("CARGO_CFG_TARGET_OS") == "none";
    let out = is_image.then(|| PathBuf::from(variable("OUT_DIR")));
    match place_for(&folder, out.as_deref()) {
        Ok(lines) => lines.iter().for_each(|line| println!("{line}")),
        Err(error) => panic!("{error}"),
    }
}

fn variable(name: &str) -> String {
    env::var(name)
        .unwrap_or_else(|_| panic!("{name} is not set: call ecss_can_memory::place() from a build script"))
}

/// Does the work of [`place`] for the package in `folder`, and returns the lines that a build script prints for cargo. Writes
/// `memory.x` into `out`, or nothing without `out`.
///
/// A package without `board.toml` gets no line `rerun-if-changed`: cargo then runs its build script at each change in the
/// package, also when a `board.toml` is added.
///
/// # Errors
/// Each [`Error`].
pub fn place_for(folder: &Path, out: Option<&Path>) -> Result<Vec<String>, Error> {
    let (manifest, board) = (folder.join("Cargo.toml"), folder.join("board.toml"));
    let chip = chip_of_manifest(&read(&manifest)?)?;
    let mut lines = Vec::new();
    if board.exists() {
        let named = chip_of_board(&read(&board)?)?;
        if !named.to_ascii_lowercase().starts_with(chip.name()) {
            return Err(Error::OtherChip { manifest: chip.name().to_owned(), board: named });
        }
        lines.extend([&manifest, &board].map(|path| format!("cargo:rerun-if-changed={}", path.display())));
    }
    if let Some(out) = out {
        let path = out.join("memory.x");
        fs::write(&path, chip.memory_map()).map_err(|reason| Error::File { path, reason })?;
        lines.push(format!("cargo:rustc-link-search={}", out.display()));
    }
    Ok(lines)
}

fn read(path: &Path) -> Result<String, Error> {
    let text = fs::read(path).map_err(|reason| Error::File { path: path.to_owned(), reason })?;
    // Comments may have any encoding.
    Ok(String::from_utf8_lossy(&text).into_owned())
}
