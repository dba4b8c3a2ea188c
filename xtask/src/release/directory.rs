//! A directory source of cargo: the published packages, and all packages of others in the versions of `Cargo.lock`.
//!
//! Cargo takes packages from it instead of the registry, by the setting `source.crates-io.replace-with`.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, ensure};
use ecss_can_cli::images::host_cargo;
use ecss_can_cli::images::support::project;
use sha2::{Digest, Sha256};

use super::archive::Archive;

/// Packages of Debian's standard library, which its toolchain compiles for boards.
const STANDARD_LIBRARY: &str = "/usr/lib/rustlib/src/rust/library/vendor";

/// Fills a folder. Packages of others come from the cache of cargo.
///
/// # Errors
/// When a package of others is not in the cache, or a file cannot be written.
pub fn fill(folder: &Path, archives: &[Archive]) -> anyhow::Result<()> {
    let mut vendor = host_cargo();
    vendor.args(["vendor", "--quiet", "--offline", "--locked", "--versioned-dirs"]).arg(folder);
    vendor.current_dir(project::path("")).stdout(Stdio::null());
    let status = vendor.status().context("cannot run cargo")?;
    ensure!(status.success(), "cargo vendor failed ({status}): run `cargo fetch` first");
    if Path::new(STANDARD_LIBRARY).is_dir() {
        let mut copy = Command::new("cp");
        let status = copy.args(["--archive", &format!("{STANDARD_LIBRARY}/.")]).arg(folder).status();
        ensure!(status.context("cannot run cp")?.success(), "cannot copy {STANDARD_LIBRARY}");
    }
    archives.iter().try_for_each(|archive| add(archive, folder))
}

/// Unpacks an archive into the source, with the file that cargo checks it by.
fn add(archive: &Archive, folder: &Path) -> anyhow::Result<()> {
    let bytes = fs::read(&archive.file).with_context(|| format!("cannot read {}", archive.file.display()))?;
    let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    let sums = serde_json::json!({ "files": {}, "package": hash });
    let file = archive.unpack(folder)?.join(".cargo-checksum.json");
    fs::write(&file, sums.to_string()).with_context(|| format!("cannot write {}", file.display()))
}

/// Returns the configuration of cargo that replaces the registry by the source in `folder`.
pub fn configuration(folder: &Path) -> String {
    format!(
        "[source.crates-io]\nreplace-with = \"packages\"\n[source.packages]\ndirectory = {:?}\n[net]\noffline = true\n",
        folder.display().to_string()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configuration_replaces_the_registry_by_the_folder() {
        let settings: toml::Table = configuration(Path::new("/a b/\"ä\"")).parse().unwrap();
        let name = settings["source"]["crates-io"]["replace-with"].as_str().unwrap();
        assert_eq!(settings["source"][name]["directory"].as_str(), Some("/a b/\"ä\""));
        assert_eq!(settings["net"]["offline"].as_bool(), Some(true));
    }
}
