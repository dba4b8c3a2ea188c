//! A directory source of cargo: the published packages, and all packages of others in the versions of `Cargo.lock`.
//!
//! Cargo takes packages from it instead of the registry, by the setting `source.crates-io.replace-with`.

use std::fs;
use std::path::Path;

use anyhow::{Context, ensure};
use ecss_can_cli::images::host_cargo;
use ecss_can_cli::images::support::project;
use sha2::{Digest, Sha256};

use super::archive::Archive;

/// Fills a folder, and returns the hash of each archive. Packages of others come from the cache of cargo.
///
/// # Errors
/// When a package of others is not in the cache, or a file cannot be written.
pub fn fill(folder: &Path, archives: &[Archive]) -> anyhow::Result<Vec<String>> {
    let mut vendor = host_cargo();
    vendor.args(["vendor", "--quiet", "--offline", "--locked", "--versioned-dirs"]).arg(folder);
    vendor.current_dir(project::path("")).stdout(std::process::Stdio::null());
    let status = vendor.status().context("cannot run cargo")?;
    ensure!(status.success(), "cargo vendor failed ({status}): run `cargo fetch` first");
    archives.iter().map(|archive| add(archive, folder)).collect()
}

/// Unpacks an archive into the source, with the file that cargo checks it by.
fn add(archive: &Archive, folder: &Path) -> anyhow::Result<String> {
    let bytes = fs::read(&archive.file).with_context(|| format!("cannot read {}", archive.file.display()))?;
    let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    let sums = serde_json::json!({ "files": {}, "package": hash });
    let file = archive.unpack(folder)?.join(".cargo-checksum.json");
    fs::write(&file, sums.to_string()).with_context(|| format!("cannot write {}", file.display()))?;
    Ok(hash)
}

/// Returns the configuration of cargo that replaces the registry by the source in `folder`.
pub fn configuration(folder: &Path) -> String {
    format!(
        "[source.crates-io]\nreplace-with = \"packages\"\n[source.packages]\ndirectory = {:?}\n[net]\noffline = true\n",
        folder.display().to_string()
    )
}
