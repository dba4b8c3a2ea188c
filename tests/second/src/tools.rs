//! Paths of third-party tools. `cargo xtask test-all --tier tools --install` installs them.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use anyhow::ensure;
use ecss_can_cli::images::support::needs::{self, Need};

/// Returns the directory of the scripts.
pub fn scripts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("python")
}

/// Returns the root of the workspace.
pub fn workspace() -> PathBuf {
    ecss_can_cli::images::support::project::path("")
}

/// Returns the files below `folder` with this extension and their texts, without build results and hidden folders.
///
/// # Panics
/// When one cannot be read.
pub fn files(folder: &Path, extension: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|found| found == extension) {
            let text = std::fs::read_to_string(&path).expect("a text");
            found.push((path, text));
        }
    }
    found
}

/// Checks that these are installed.
///
/// # Errors
/// When one is missing. The error says how to install it.
pub fn require(needs: &[Need]) -> anyhow::Result<()> {
    let missing: Vec<String> = needs.iter().filter(|need| !need.is_there()).map(Need::to_string).collect();
    ensure!(
        missing.is_empty(),
        "missing: {}; run `cargo xtask test-all --tier tools --install`",
        missing.join(", ")
    );
    Ok(())
}

/// Returns the path of a Python with the packages of `python/requirements.txt`.
///
/// # Errors
/// When they are missing. The error says how to install them.
pub fn python() -> anyhow::Result<PathBuf> {
    // Asked once, because Python takes a tenth of a second.
    static IS_THERE: LazyLock<bool> = LazyLock::new(|| Need::PythonPackages.is_there());
    if !*IS_THERE {
        require(&[Need::PythonPackages])?;
    }
    Ok(needs::python())
}

/// Prints a line on stderr past the test harness, which shows its own capture of stderr only after a failure.
pub(crate) fn note(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
