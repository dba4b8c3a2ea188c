//! Each statement of README, limits and SECURITY has a line in docs/statements.md, with a test, a row or a page as
//! evidence.

use std::collections::BTreeSet;

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};
use second::tools::files;
use serde_json::Value;

use crate::docs::{root, text};

/// Headings of docs/statements.md and the pages whose promises follow.
const PAGES: [(&str, &str); 3] =
    [("README", "README.md"), ("Limits", "docs/limits.md"), ("SECURITY", "SECURITY.md")];

/// Sections without statements.
const WITHOUT_PROMISES: [&str; 3] = ["Supported versions", "How to report", "Flashing"];

/// Contents of a document.
#[derive(Debug, Default)]
struct Page {
    /// Complete text.
    text: String,
    /// Items of lists, and rows of tables: the heading above, the text of each cell, and what stands in backticks in it.
    items: Vec<(String, Vec<Cell>)>,
}

#[derive(Clone, Debug, Default)]
struct Cell {
    text: String,
    codes: Vec<String>,
}

/// Returns the text with one space between words.
fn plain(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn read(markdown: &str) -> Page {
    let mut page = Page::default();
    let (mut heading, mut is_heading, mut cells) = (String::new(), false, None::<Vec<Cell>>);
    for event in Parser::new_ext(markdown, Options::ENABLE_TABLES) {
        let piece = match &event {
            Event::Text(text) => text.to_string(),
            Event::Code(code) => code.to_string(),
            Event::SoftBreak | Event::HardBreak | Event::End(_) => " ".to_owned(),
            _ => String::new(),
        };
        page.text.push_str(&piece);
        match event {
            Event::Start(Tag::Heading { .. }) => (heading, is_heading) = (String::new(), true),
            Event::End(TagEnd::Heading(_)) => is_heading = false,
            Event::Start(Tag::TableRow) => cells = Some(Vec::new()),
            Event::Start(Tag::Item) => cells = Some(vec![Cell::default()]),
            Event::Start(Tag::TableCell) => cells.iter_mut().for_each(|cells| cells.push(Cell::default())),
            Event::End(TagEnd::TableRow | TagEnd::Item) => {
                page.items.extend(cells.take().map(|cells| (heading.clone(), cells)));
            }
            _ if is_heading => heading.push_str(&piece),
            event => {
                if let Some(cell) = cells.as_mut().and_then(|cells| cells.last_mut()) {
                    cell.text.push_str(&piece);
                    if let Event::Code(code) = event {
                        cell.codes.push(code.into_string());
                    }
                }
            }
        }
    }
    page.text = plain(&page.text);
    page
}

/// Returns the errors in the statements of a section about a page.
fn faults(section: &str, statements: &Page, page: &Page) -> Vec<String> {
    let of_section = statements.items.iter().filter(|(heading, _)| heading == section);
    let quotes: Vec<String> = of_section.map(|(_, cells)| plain(&cells[0].text)).collect();
    let strange = quotes.iter().filter(|quote| !page.text.contains(quote.as_str()));
    let mut found: Vec<String> = strange.map(|quote| format!("not on the page: {quote}")).collect();
    for (heading, cells) in &page.items {
        let item = plain(&cells.iter().map(|cell| cell.text.clone() + " ").collect::<String>());
        if !WITHOUT_PROMISES.contains(&heading.as_str())
            && !quotes.iter().any(|quote| item.contains(quote.as_str()))
        {
            found.push(format!("no statement has: {item}"));
        }
    }
    found
}

/// Returns the names of the functions in the sources below `folder`.
fn functions(folder: &str) -> Vec<String> {
    let sources = files(&root().join(folder), "rs").into_iter();
    let names = |(_, text): (_, String)| -> Vec<String> {
        let names = text.split("fn ").skip(1).filter_map(|after| after.split(['(', '<']).next());
        names.map(str::to_owned).collect()
    };
    sources.flat_map(names).collect()
}

#[test]
fn each_promise_has_a_statement() {
    let statements = read(&text("docs/statements.md"));
    for (section, path) in PAGES {
        assert_eq!(faults(section, &statements, &read(&text(path))), [""; 0], "{path}");
    }
}

#[test]
fn each_statement_is_held_by_what_is_there() {
    let rows: Value = serde_json::from_str(&text("xtask/bench/stored.json")).expect("rows");
    let folders = ["shared", "boards", "firmware", "twin", "tools", "tests", "xtask"];
    let tests: BTreeSet<String> = folders.into_iter().flat_map(functions).collect();
    for (_, cells) in read(&text("docs/statements.md")).items {
        let [statement, holder] = &cells[..] else { panic!("two cells: {cells:?}") };
        assert!(!plain(&holder.text).is_empty(), "nothing holds: {}", statement.text);
        for code in holder.codes.iter().filter(|code| !code.contains(' ')) {
            let is_there = tests.contains(code) || rows.get(code).is_some();
            assert!(is_there || root().join(code).exists(), "{}: there is no {code}", statement.text);
        }
    }
}

/// Given a page with an item that no statement has, and a statement that is not on the page, then both are found.
#[test]
fn promise_without_statement_and_statement_without_promise_are_found() {
    let page = read(
        "# A\n\n* It runs, [always](b.md).\n* It is\n  quick.\n\n| a | b |\n| - | - |\n| c | takes <!--=x-->5<!--.--> ms |\n",
    );
    let statements = |rows: &str| read(&format!("## S\n\n| statement | held by |\n| - | - |\n{rows}"));
    let all = "| It runs, always | `t` |\n| is quick | x |\n| takes 5 ms | x |\n";
    assert_eq!(faults("S", &statements(all), &page), [""; 0]);
    let other = "| It runs, always | `t` |\n| takes 6 ms | x |\n| is quick | x |\n";
    assert_eq!(
        faults("S", &statements(other), &page),
        ["not on the page: takes 6 ms", "no statement has: c takes 5 ms"]
    );
}
