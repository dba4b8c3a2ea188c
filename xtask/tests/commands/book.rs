//! The pages of docs/ as a book: each page is in its contents, none is too long, and the README shows tested code.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

use crate::docs::{documents, read, root, text};

/// Pages that commands write.
const GENERATED: [&str; 2] = ["docs/compliance.md", "docs/api.md"];

/// A page that people look up terms in.
const GLOSSARY: &str = "docs/glossary.md";

/// Markers of the tables that `cargo xtask bench --store` writes.
const TABLE: (&str, &str) = ("<!-- rows: ", "<!-- end of rows -->");

/// Returns the number of words of a document without tables and blocks of code.
fn words(text: &str) -> usize {
    let (mut count, mut skipped) = (0, 0_u32);
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Table(_) | Tag::CodeBlock(_)) => skipped += 1,
            Event::End(TagEnd::Table | TagEnd::CodeBlock) => skipped -= 1,
            Event::Text(text) | Event::Code(text) if skipped == 0 => count += text.split_whitespace().count(),
            _ => {}
        }
    }
    count
}

/// Words of a document as `wc` counts them, without tables that commands write.
fn whole(text: &str) -> usize {
    let mut parts = text.split(TABLE.0);
    let first = parts.next().unwrap_or_default();
    let rest = parts.map(|part| part.split_once(TABLE.1).expect("the end of a table").1);
    std::iter::once(first).chain(rest).map(|part| part.split_whitespace().count()).sum()
}

/// A document without its blocks of code.
fn without_code(text: &str) -> String {
    let mut rest = text.to_owned();
    let blocks = Parser::new(text).into_offset_iter().filter_map(|(event, range)| match event {
        Event::Start(Tag::CodeBlock(_)) => Some(range),
        _ => None,
    });
    for block in blocks.collect::<Vec<_>>().into_iter().rev() {
        rest.replace_range(block, "");
    }
    rest
}

/// Path from the root of the repository.
fn name(file: &Path) -> String {
    file.strip_prefix(root()).expect("a file of the repository").to_string_lossy().into_owned()
}

#[test]
fn every_page_is_in_the_contents_of_the_book_once() {
    let docs = root().join("docs");
    let pages: BTreeSet<PathBuf> =
        documents(&docs).into_iter().filter(|file| !file.ends_with("SUMMARY.md")).collect();
    let listed: Vec<PathBuf> =
        read(&text("docs/SUMMARY.md")).links.iter().map(|link| docs.join(link)).collect();
    let once: BTreeSet<PathBuf> = listed.iter().cloned().collect();
    assert_eq!(once, pages, "docs/SUMMARY.md lists the left ones, these are the right ones");
    assert_eq!(listed.len(), once.len(), "docs/SUMMARY.md lists a page twice");
}

#[test]
fn pages_for_people_have_at_most_1500_words() {
    let pages =
        documents(&root().join("docs")).into_iter().map(|file| (words(&text(&name(&file))), name(&file)));
    let long: Vec<_> =
        pages.filter(|(count, name)| *count > 1_500 && !GENERATED.contains(&name.as_str())).collect();
    assert!(long.is_empty(), "split these pages by question: {long:?}");
}

/// Given all pages but the generated ones and the glossary, counted with their tables: each with its code, all without.
#[test]
fn pages_have_at_most_2000_words_and_60000_together() {
    let names = documents(&root().join("docs")).into_iter().map(|file| name(&file));
    let names = names.filter(|name| !GENERATED.contains(&name.as_str()) && name != GLOSSARY);
    let pages: Vec<(String, String)> = names.map(|name| (text(&name), name)).collect();
    let counts = pages.iter().map(|(text, name)| (whole(text), name));
    let long: Vec<_> = counts.filter(|(count, _)| *count > 2_000).collect();
    assert!(long.is_empty(), "split these pages by question, or cut them: {long:?}");
    let together: usize = pages.iter().map(|(text, _)| whole(&without_code(text))).sum();
    assert!(together <= 60_000, "all pages together have {together} words: cut or merge some");
}

#[test]
fn front_pages_are_short() {
    let count = |path: &str| whole(&text(path));
    assert!(count("README.md") <= 1_300, "README.md: {} words", count("README.md"));
    assert!(count("CONTRIBUTING.md") <= 900, "CONTRIBUTING.md: {} words", count("CONTRIBUTING.md"));
    let changelog = text("CHANGELOG.md");
    for version in ["0.2.0", "0.1.0"] {
        let (_, entry) = changelog.split_once(&format!("## [{version}]")).expect(version);
        let lines = entry.split("\n## [").next().expect("a first part").lines().count();
        assert!(lines <= 60, "CHANGELOG.md: {version} has {lines} lines");
    }
}

/// Lines of Rust in a document, without comments.
fn rust(text: &str) -> Vec<String> {
    let (mut lines, mut is_rust) = (Vec::new(), false);
    for event in Parser::new(text) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(language))) => {
                is_rust = language.starts_with("rust")
            }
            Event::End(TagEnd::CodeBlock) => is_rust = false,
            Event::Text(code) if is_rust => lines.extend(code.lines().map(str::to_owned)),
            _ => {}
        }
    }
    lines.retain(|line| !line.trim_start().starts_with("//"));
    lines
}

/// Given the device of the README and of the page about moving, then each of its lines is one of the template of a slave, which tests build and fly.
#[test]
fn pages_show_code_that_tests_build() {
    const TEMPLATE: &str = "tools/templates/slave/src/lib.rs";
    let tested = text(TEMPLATE);
    let tested: BTreeSet<&str> = tested.lines().collect();
    for page in ["README.md", "docs/moving.md"] {
        let shown = rust(&text(page));
        assert!(shown.len() > 5, "{page}: {shown:?}");
        let untested: Vec<_> = shown.iter().filter(|line| !tested.contains(line.as_str())).collect();
        assert!(untested.is_empty(), "{page}: not in {TEMPLATE}: {untested:#?}");
    }
}

#[test]
fn page_about_ports_shows_its_slave_of_60_lines_as_it_is_compiled() {
    let slave = text("firmware/examples/embassy-slave/src/bin/fdcan.rs");
    assert!(slave.lines().count() <= 60);
    assert!(text("docs/ports.md").contains(&format!("```rust,ignore\n{slave}```")));
}

#[test]
fn words_in_tables_and_code_do_not_count() {
    let page = "# Two words\n\nThree `more` words.\n\n| a | b |\n| - | - |\n| c d | e |\n\n    code here\n";
    assert_eq!(words(page), 5);
    assert_eq!(without_code(page).split_whitespace().count(), 22);
    assert_eq!(whole("# Two words\n\n<!-- rows: a.* -->\n| c |\n<!-- end of rows -->\n\n| d |\n"), 6);
    assert_eq!(rust("```rust\nlet a = 1;\n// no\n```\n\n```sh\nls\n```\n"), ["let a = 1;"]);
}
