//! The pages of docs/ as a book: each page is in its contents, none is too long, and the README shows tested code.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

use crate::docs::{documents, read, root, text};

/// Pages that commands write.
const GENERATED: [&str; 2] = ["docs/compliance.md", "docs/performance.md"];

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

#[test]
fn front_pages_are_short() {
    let whole = |path: &str| text(path).split_whitespace().count();
    assert!(whole("README.md") <= 1_300, "README.md: {} words", whole("README.md"));
    assert!(whole("CONTRIBUTING.md") <= 900, "CONTRIBUTING.md: {} words", whole("CONTRIBUTING.md"));
    let changelog = text("CHANGELOG.md");
    let (_, entry) = changelog.split_once("## [0.1.0]").expect("an entry of 0.1.0");
    let lines = entry.split("\n## [").next().expect("a first part").lines().count();
    assert!(lines <= 60, "CHANGELOG.md: 0.1.0 has {lines} lines");
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

/// Given the device of the README, then each of its lines is one of docs/your-own.md, which tests build and fly.
#[test]
fn readme_shows_code_that_tests_build() {
    let tested: BTreeSet<String> = rust(&text("docs/your-own.md")).into_iter().collect();
    let shown = rust(&text("README.md"));
    assert!(shown.len() > 5, "{shown:?}");
    let untested: Vec<_> = shown.iter().filter(|line| !tested.contains(*line)).collect();
    assert!(untested.is_empty(), "not in docs/your-own.md: {untested:#?}");
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
    assert_eq!(rust("```rust\nlet a = 1;\n// no\n```\n\n```sh\nls\n```\n"), ["let a = 1;"]);
}
