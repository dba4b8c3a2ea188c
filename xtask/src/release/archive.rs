//! The `.crate` files of the published packages.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};
use cargo_metadata::Package;
use ecss_can_cli::images::host_cargo;
use ecss_can_cli::images::support::project;

use super::BUILT;
use super::front::FILES;

/// Largest `.crate` file, in bytes: the limit of crates.io.
const LIMIT: u64 = 10 * 1024 * 1024;

/// A `.crate` file.
#[derive(Debug)]
pub struct Archive {
    /// Name of the package.
    pub name: String,
    /// Name and version, as of its folder: `ecss-can-0.2.0`.
    pub stem: String,
    pub file: PathBuf,
    /// Size in bytes.
    pub bytes: u64,
    /// Paths of the files in it, from its folder.
    pub contents: Vec<String>,
}

/// Packs these packages, and compiles each from its file, with the others from theirs.
///
/// # Errors
/// When a file of the project is not committed, or a package does not compile alone.
pub fn make(packages: &[&Package]) -> anyhow::Result<Vec<Archive>> {
    let target = project::target(BUILT);
    let mut cargo = host_cargo();
    cargo.args(["package", "--offline", "--locked"]).current_dir(project::path(""));
    cargo.arg("--target-dir").arg(&target);
    for package in packages {
        cargo.args(["--package", &package.name]);
    }
    let status = cargo.status().context("cannot run cargo")?;
    ensure!(status.success(), "cargo package failed ({status}), see above");
    packages.iter().map(|package| Archive::of(package, &target.join("package"))).collect()
}

impl Archive {
    fn of(package: &Package, folder: &Path) -> anyhow::Result<Archive> {
        let stem = format!("{}-{}", package.name, package.version);
        let file = folder.join(format!("{stem}.crate"));
        let bytes = fs::metadata(&file).with_context(|| format!("no {}", file.display()))?.len();
        let listed = Command::new("tar").arg("-tzf").arg(&file).output().context("cannot run tar")?;
        ensure!(listed.status.success(), "tar cannot read {}", file.display());
        let listed = String::from_utf8(listed.stdout).context("names of files")?;
        let contents = listed.lines().filter_map(|path| path.strip_prefix(&format!("{stem}/")));
        let contents = contents.map(str::to_owned).collect();
        Ok(Archive { name: package.name.to_string(), stem, file, bytes, contents })
    }

    /// Returns what is wrong with size and contents.
    pub fn faults(&self) -> Vec<String> {
        let missing = FILES.iter().filter(|file| !self.contents.iter().any(|path| path == *file));
        let mut faults: Vec<String> =
            missing.map(|file| format!("{}: the package does not contain {file}", self.name)).collect();
        if self.bytes > LIMIT {
            faults.push(format!("{}: {} bytes; allowed are {LIMIT}", self.name, self.bytes));
        }
        faults
    }

    /// Unpacks it into a folder of its own in `parent`, and returns that folder.
    ///
    /// # Errors
    /// When tar cannot be run, or fails.
    pub fn unpack(&self, parent: &Path) -> anyhow::Result<PathBuf> {
        let mut tar = Command::new("tar");
        let status =
            tar.arg("-xzf").arg(&self.file).arg("-C").arg(parent).status().context("cannot run tar")?;
        ensure!(status.success(), "tar cannot unpack {}", self.file.display());
        Ok(parent.join(&self.stem))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_archive_and_missing_files_are_faults() {
        let contents = ["README.md", "LICENSE-MIT"].map(str::to_owned).to_vec();
        let mut archive = Archive {
            name: "a".into(),
            stem: "a-1.0.0".into(),
            file: PathBuf::new(),
            bytes: LIMIT,
            contents,
        };
        assert_eq!(archive.faults(), ["a: the package does not contain LICENSE-APACHE"]);
        archive.bytes += 1;
        archive.contents.push("LICENSE-APACHE".into());
        assert_eq!(archive.faults(), ["a: 10485761 bytes; allowed are 10485760"]);
    }
}
