//! Checks of Markdown files: links, anchors, paths of files, the form of decisions.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use cargo_metadata::{Metadata, MetadataCommand};
use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use second::tools::files;

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace").to_owned()
}

/// Returns the text of a file of the repository, by its path from the root.
pub fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The packages of this workspace.
pub fn metadata() -> Metadata {
    MetadataCommand::new().current_dir(root()).no_deps().exec().expect("cargo knows its packages")
}

/// Markdown files below `folder`, without build results and hidden folders.
pub fn documents(folder: &Path) -> Vec<PathBuf> {
    files(folder, "md").into_iter().map(|(path, _)| path).collect()
}

/// References of a document, and their possible targets in it.
#[derive(Default)]
pub struct Document {
    /// Anchors of its headings, as GitHub makes them.
    anchors: BTreeSet<String>,
    /// Destinations of links and pictures.
    pub links: Vec<String>,
    /// Text in backticks.
    codes: Vec<String>,
    /// Headings of level 1 and 2.
    titles: Vec<String>,
}

/// Lower case, spaces as hyphens, no other punctuation than hyphen and underscore.
fn anchor(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter(|letter| letter.is_alphanumeric() || matches!(letter, ' ' | '-' | '_'))
        .map(|letter| if letter == ' ' { '-' } else { letter })
        .collect()
}

pub fn read(text: &str) -> Document {
    let mut document = Document::default();
    let mut heading: Option<String> = None;
    let mut repeats: BTreeMap<String, u32> = BTreeMap::new();
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                document.links.push(dest_url.into_string());
            }
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(level)) => {
                let title = heading.take().expect("a heading ends after its start");
                let plain = anchor(&title);
                let count = repeats.entry(plain.clone()).or_default();
                let unique = if *count == 0 { plain } else { format!("{plain}-{count}") };
                *count += 1;
                document.anchors.insert(unique);
                if level as usize <= 2 {
                    document.titles.push(title);
                }
            }
            Event::Text(part) => heading.iter_mut().for_each(|title| title.push_str(&part)),
            Event::Code(code) => {
                heading.iter_mut().for_each(|title| title.push_str(&code));
                document.codes.push(code.into_string());
            }
            _ => {}
        }
    }
    document
}

/// Returns broken links of `file`, each with the reason.
fn broken_links(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).expect("a text");
    let mut broken = Vec::new();
    for link in read(&text).links {
        if link.contains("://") || link.starts_with("mailto:") {
            continue;
        }
        let (path, wanted) =
            link.split_once('#').map_or((link.as_str(), None), |(path, part)| (path, Some(part)));
        let target =
            if path.is_empty() { file.to_owned() } else { file.parent().expect("a folder").join(path) };
        if !target.exists() {
            broken.push(format!("{}: {link}: no such file", file.display()));
        } else if let Some(wanted) = wanted
            && !read(&fs::read_to_string(&target).expect("a text")).anchors.contains(wanted)
        {
            broken.push(format!("{}: {link}: no such heading", file.display()));
        }
    }
    broken
}

/// Returns paths in backticks that start with a folder of `root` and do not exist.
fn missing_paths(root: &Path, file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).expect("a text");
    let is_plain =
        |code: &str| !code.contains(|letter: char| letter.is_whitespace() || "{}*<>$".contains(letter));
    read(&text)
        .codes
        .into_iter()
        .filter(|code| is_plain(code) && !code.starts_with("target/"))
        .filter(|code| {
            code.split_once('/').is_some_and(|(folder, _)| !folder.is_empty() && root.join(folder).is_dir())
        })
        .filter(|code| !root.join(code).exists())
        .map(|code| format!("{}: `{code}` is not there", file.display()))
        .collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let documents = documents(&root());
    assert!(documents.iter().any(|file| file.ends_with("docs/architecture.md")), "{documents:?}");
    let broken: Vec<_> = documents.iter().flat_map(|file| broken_links(file)).collect();
    assert!(broken.is_empty(), "mend these links: {broken:#?}");
}

/// The changelog may name removed files. Templates name those of the project that is made of them.
#[test]
fn every_path_in_backticks_exists() {
    let root = root();
    let templates = root.join("tools/templates");
    let documents = documents(&root).into_iter();
    let documents = documents.filter(|file| !file.ends_with("CHANGELOG.md") && !file.starts_with(&templates));
    let missing: Vec<_> = documents.flat_map(|file| missing_paths(&root, &file)).collect();
    assert!(missing.is_empty(), "mend these paths: {missing:#?}");
}

#[test]
fn every_decision_is_in_the_index_and_has_its_parts() {
    let folder = root().join("docs/decisions");
    let index = read(&fs::read_to_string(folder.join("README.md")).expect("an index"));
    let pages: Vec<_> = documents(&folder).into_iter().filter(|file| !file.ends_with("README.md")).collect();
    assert!(pages.len() > 15, "{pages:?}");
    let mut faults = Vec::new();
    for page in pages {
        let name = page.file_name().expect("a name").to_string_lossy().into_owned();
        if !index.links.contains(&name) {
            faults.push(format!("{name}: no line in docs/decisions/README.md"));
        }
        let text = fs::read_to_string(&page).expect("a text");
        let titles = read(&text).titles;
        // A table of many small decisions has a reason in each row.
        let is_table = name == "where-the-standard-leaves-room.md";
        for part in ["Context", "Decision", "Consequences", "What would change it"] {
            if !is_table && !titles.iter().any(|title| title == part) {
                faults.push(format!("{name}: no heading \"{part}\""));
            }
        }
    }
    assert!(faults.is_empty(), "mend these pages: {faults:#?}");
}

/// Given the table of CONTRIBUTING.md, then it lists exactly the folders whose crate has another name.
#[test]
fn crates_named_unlike_their_folders_have_a_reason() {
    let root = root();
    let packages = metadata().packages.into_iter().map(|package| {
        let folder = package.manifest_path.parent().expect("a folder").strip_prefix(&root);
        (folder.expect("a folder of this workspace").to_string(), package.name.to_string())
    });
    let differing: BTreeSet<_> =
        packages.filter(|(folder, name)| folder.rsplit('/').next() != Some(name.as_str())).collect();
    let page = text("docs/packages.md");
    let (_, table) = page.split_once("## Published").expect("the heading of the table");
    let (table, _) = table.split_once("## ").expect("a heading below the table");
    let listed: BTreeSet<_> = read(table)
        .codes
        .chunks(2)
        .map(|pair| (pair[0].clone(), pair.get(1).expect("a crate beside each folder").clone()))
        .collect();
    assert_eq!(listed, differing, "docs/packages.md lists the left ones, these are the right ones");
}

/// Given a document with one good and one bad reference of each kind, then only the bad ones are reported.
#[test]
fn a_broken_reference_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("shared")).expect("a folder");
    fs::write(at("shared/lib.rs"), "").expect("a file");
    fs::write(at("b.md"), "# What is `it`?\n## Twice\n## Twice\n").expect("a file");
    let links = "[1](b.md) [2](b.md#what-is-it) [3](b.md#twice-1) [4](https://example.org/c.md) [5](#here)\n";
    let bad = "[6](c.md) [7](b.md#twice-2) ![8](b.svg) [9](#there)\n";
    let paths = "`shared/lib.rs` `shared/gone.rs` `shared/{a,b}.rs` `other/gone.rs`\n";
    fs::write(at("a.md"), format!("# Here\n\n{links}{bad}{paths}")).expect("a file");

    let reported = broken_links(&at("a.md"));
    let ends = [
        "c.md: no such file",
        "b.md#twice-2: no such heading",
        "b.svg: no such file",
        "#there: no such heading",
    ];
    assert_eq!(reported.len(), ends.len(), "{reported:?}");
    for (reported, end) in reported.iter().zip(ends) {
        assert!(reported.ends_with(end), "{reported}");
    }
    let missing = missing_paths(folder.path(), &at("a.md"));
    assert_eq!(missing, [format!("{}: `shared/gone.rs` is not there", at("a.md").display())]);
}
