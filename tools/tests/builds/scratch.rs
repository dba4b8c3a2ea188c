//! A temporary package outside the workspace.

use std::fs;
use std::path::{Path, PathBuf};

use ecss_can_cli::images::{Package, Refusal};

/// Root of this repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(1).expect("a workspace").to_owned()
}

/// Returns the errors of the build of a package with these files. `ROOT` in its manifest is this repository.
pub fn refusals(manifest: &str, files: &[(&str, &str)]) -> Vec<Refusal> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    fs::create_dir(folder.path().join("src")).expect("a folder");
    fs::copy(root().join("Cargo.lock"), folder.path().join("Cargo.lock")).expect("a lock");
    let head = "[package]\nname = \"scratch\"\nversion = \"0.1.0\"\nedition = \"2024\"\n[workspace]\n";
    write("Cargo.toml", &(head.to_owned() + &manifest.replace("ROOT", &root().display().to_string())));
    files.iter().for_each(|(name, text)| write(name, text));
    let package = Package { name: "scratch".into(), manifest: folder.path().join("Cargo.toml") };
    package.refusals(None::<&str>).expect("it is compiled")
}
