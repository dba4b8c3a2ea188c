//! Links between the published packages: each front page leads to others, and none is without a way to it.
//!
//! A package has two *front pages*: README.md, and the first page of its documentation.

use std::collections::BTreeSet;
use std::fs;

use cargo_metadata::Package;

/// Fewest other packages that a front page names.
const FEWEST: usize = 2;
/// Address of the documentation of a package.
const ADDRESS: &str = "](https://docs.rs/";
/// Beginnings of the names of all published packages.
const NAMES: [&str; 3] = ["async-canopen", "ecss-can", "can-twin"];

/// Returns the links that are missing between these packages, and those to packages that are not published.
pub fn faults(packages: &[&Package]) -> Vec<String> {
    let pages: Vec<_> = packages.iter().flat_map(|package| pages(package)).collect();
    let names: Vec<&str> = packages.iter().map(|package| package.name.as_str()).collect();
    of_pages(&names, &pages)
}

/// A front page.
struct Page {
    package: String,
    file: &'static str,
    text: String,
}

fn pages(package: &Package) -> [Page; 2] {
    let library = package.targets.iter().find(|target| target.is_lib() || target.is_proc_macro());
    let source = library.and_then(|target| fs::read_to_string(&target.src_path).ok()).unwrap_or_default();
    let documentation = source.lines().filter(|line| line.starts_with("//!")).collect();
    let readme = package.manifest_path.with_file_name("README.md");
    let texts = [
        ("README.md", fs::read_to_string(readme).unwrap_or_default()),
        ("crate documentation", documentation),
    ];
    texts.map(|(file, text)| Page { package: package.name.to_string(), file, text })
}

fn of_pages(names: &[&str], pages: &[Page]) -> Vec<String> {
    let (mut faults, mut all) = (Vec::new(), BTreeSet::new());
    for Page { package, file, text } in pages {
        let others: BTreeSet<&str> = links(text).filter(|name| name != package).collect();
        if others.len() < FEWEST {
            faults.push(format!("{package}: its {file} names fewer than {FEWEST} other published packages"));
        }
        let unknown = others.iter().filter(|name| !names.contains(name));
        faults.extend(
            unknown.map(|name| format!("{package}: its {file} names {name}, which is not published")),
        );
        all.extend(others);
    }
    let alone = names.iter().filter(|name| !all.contains(*name));
    faults.extend(alone.map(|name| format!("{name}: no front page of another package names it")));
    faults
}

/// Returns the packages of this project whose documentation a page links to.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let names = text.split(ADDRESS).skip(1).filter_map(|rest| rest.split(['/', ')', '#']).next());
    names.filter(|name| NAMES.iter().any(|start| name.starts_with(start)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::{metadata, published};

    #[test]
    fn front_pages_of_published_packages_lead_to_all_others() {
        let metadata = metadata().unwrap();
        assert_eq!(faults(&published(&metadata)), [""; 0]);
    }

    /// Given a page with one link to another package and one to a package that is not published, and a package without a link to it,
    /// then these are faults. Links to packages of others and to the own package do not count.
    #[test]
    fn missing_and_wrong_links_are_faults() {
        let link = |name: &str| format!("[`{name}`](https://docs.rs/{name}) ");
        let page = |package: &str, linked: &[&str]| {
            let text = linked.iter().map(|name| link(name)).collect();
            Page { package: package.into(), file: "README.md", text }
        };
        let names = ["ecss-can", "can-twin", "async-canopen"];
        let pages = [
            page("ecss-can", &["can-twin", "ecss-can", "heapless"]),
            page("can-twin", &["ecss-can", "ecss-can-tools/latest/tools"]),
        ];
        let expected = [
            "ecss-can: its README.md names fewer than 2 other published packages",
            "can-twin: its README.md names ecss-can-tools, which is not published",
            "async-canopen: no front page of another package names it",
        ];
        assert_eq!(of_pages(&names, &pages), expected);
    }
}
