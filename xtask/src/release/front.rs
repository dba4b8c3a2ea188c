//! Manifests and front pages of the published packages.

use std::fs;
use std::path::Path;

use cargo_metadata::{DependencyKind, Package};

/// Highest number of published packages.
const PACKAGES: usize = 15;
/// Limits of crates.io for keywords.
const KEYWORDS: usize = 5;
const KEYWORD_LENGTH: usize = 20;
/// Files that each package contains.
pub const FILES: [&str; 3] = ["README.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Returns what is wrong with these packages in version `version`.
pub fn faults(packages: &[&Package], version: &str) -> Vec<String> {
    let mut faults: Vec<String> = packages.iter().flat_map(|package| of_package(package, version)).collect();
    if packages.len() > PACKAGES {
        faults.push(format!("{} packages are published; allowed are {PACKAGES}", packages.len()));
    }
    faults
}

fn of_package(package: &Package, version: &str) -> Vec<String> {
    let keywords = &package.keywords;
    let mut faults = Vec::new();
    let mut expect = |is_met: bool, fault: &str| {
        if !is_met {
            faults.push(format!("{}: {fault}", package.name));
        }
    };
    expect(package.version.to_string() == version, "its version is not that of the other packages");
    expect(package.description.is_some(), "no description");
    expect(package.license.is_some(), "no licence");
    expect(package.rust_version.is_some(), "no rust-version");
    expect(!package.categories.is_empty(), "no categories");
    expect(
        (1..=KEYWORDS).contains(&keywords.len()) && keywords.iter().all(|word| word.len() <= KEYWORD_LENGTH),
        "1 to 5 keywords of at most 20 characters are allowed",
    );
    let folder = package.manifest_path.parent().map_or(Path::new("."), |folder| folder.as_std_path());
    for file in FILES {
        expect(folder.join(file).is_file(), &format!("no {file}"));
    }
    for dependency in &package.dependencies {
        let is_kept = dependency.kind != DependencyKind::Development && dependency.path.is_some();
        let is_exact = dependency.req.to_string() == format!("^{version}");
        expect(!is_kept || is_exact, &format!("{} is required in another version", dependency.name));
    }
    let readme = fs::read_to_string(folder.join(FILES[0])).unwrap_or_default();
    for link in local_links(&readme) {
        expect(false, &format!("README.md: {link} is not in the package; name a page of docs.rs"));
    }
    faults
}

/// Returns the destinations of links that are neither addresses nor headings.
fn local_links(markdown: &str) -> Vec<&str> {
    let links = markdown.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    links.filter(|link| !link.starts_with('#') && !link.contains("://")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::{metadata, published, version};

    #[test]
    fn published_packages_have_front_pages_licences_and_one_version() {
        let metadata = metadata().unwrap();
        let packages = published(&metadata);
        let names: Vec<&str> = packages.iter().map(|package| package.name.as_str()).collect();
        assert!(names.contains(&"async-canopen") && names.contains(&"ecss-can-cli"), "{names:?}");
        assert!(!names.contains(&"xtask"), "{names:?}");
        assert_eq!(faults(&packages, &version(&packages).unwrap()), [""; 0]);
    }

    /// Given a package without front page, keywords and licence files, and with another version than the release, then each is a fault.
    #[test]
    fn each_missing_part_of_a_manifest_is_a_fault() {
        let metadata = metadata().unwrap();
        let packages = metadata.workspace_packages();
        let xtask = packages.iter().find(|package| package.name == "xtask").unwrap();
        let found = faults(&[xtask], "9.9.9").join("\n");
        for fault in ["its version", "no description", "no categories", "1 to 5 keywords", "no LICENSE-MIT"] {
            assert!(found.contains(&format!("xtask: {fault}")), "no {fault:?} in\n{found}");
        }
        assert!(found.contains("ecss-can is required in another version"), "{found}");
        assert!(!found.contains("tempfile"), "{found}");
    }

    #[test]
    fn links_out_of_a_package_are_found() {
        let text = "[a](https://docs.rs/a) [b](#b) [c](../c.md)";
        assert_eq!(local_links(text), ["../c.md"]);
    }
}
