//! The tables of `docs/performance.md` and `docs/performance-details.md`, made from the stored rows.
//!
//! The pages have sections, and `cargo xtask bench --store` writes the text between their markers:
//!
//! ```text
//! <!-- rows: size.*.*.ram size.canopen_only -->
//! <!-- end of rows -->
//! ```
//!
//! A pattern is the name of a row, in which `*` matches any letters except a dot. Rows are in the order of the
//! patterns, then of their names.

use std::fmt::Write as _;
use std::fs;

use anyhow::{Context, bail};
use ecss_can_cli::images::support::project;
use serde_json::Value;

use super::stored::Stored;
use super::table::number;

const START: &str = "<!-- rows: ";
const START_ENDS: &str = " -->";
const END: &str = "<!-- end of rows -->";

/// The page with the rows that decide. The other page has them too.
const PAGE: &str = "docs/performance.md";

/// The page with all rows.
const DETAILS: &str = "docs/performance-details.md";

/// Writes the tables of both pages anew.
///
/// # Errors
/// When a page cannot be read or written, or as [`with_tables`].
pub fn update(stored: &Stored) -> anyhow::Result<()> {
    [PAGE, DETAILS].into_iter().try_for_each(|page| rewrite(page, |text| with_tables(text, stored)))
}

/// Writes a page of the project anew.
///
/// # Errors
/// When it cannot be read or written, and those of `change`.
pub fn rewrite(page: &str, change: impl FnOnce(&str) -> anyhow::Result<String>) -> anyhow::Result<()> {
    let path = project::path(page);
    let text = fs::read_to_string(&path).with_context(|| format!("cannot read {page}"))?;
    let text = change(&text).with_context(|| format!("cannot update {page}"))?;
    fs::write(&path, text).with_context(|| format!("cannot write {page}"))
}

/// Returns the page with tables of these rows.
///
/// # Errors
/// When a section has no end.
fn with_tables(page: &str, stored: &Stored) -> anyhow::Result<String> {
    let mut text = String::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        writeln!(text, "{line}")?;
        let Some(patterns) = patterns(line) else { continue };
        if !lines.by_ref().any(|line| line == END) {
            bail!("no line '{END}' follows '{line}'");
        }
        writeln!(text, "\n{}\n{END}", table(patterns, stored))?;
    }
    Ok(text)
}

/// Returns the patterns of a marker.
fn patterns(line: &str) -> Option<&str> {
    line.strip_prefix(START)?.strip_suffix(START_ENDS)
}

/// Returns a table in Markdown. Without rows it states how to measure them.
fn table(patterns: &str, stored: &Stored) -> String {
    let of_pattern = |pattern| stored.rows().filter(move |(name, _)| is_match(pattern, name));
    let lines: String =
        patterns.split_whitespace().flat_map(of_pattern).map(|(name, row)| line(name, row)).collect();
    if lines.is_empty() {
        return "No row is stored. `cargo xtask bench --only AREA --store` measures an area.\n".into();
    }
    format!("| row | value | target | |\n| --- | --- | --- | --- |\n{lines}")
}

/// Returns whether a name matches a pattern.
fn is_match(pattern: &str, name: &str) -> bool {
    let Some((before, after)) = pattern.split_once('*') else { return pattern == name };
    name.strip_prefix(before).is_some_and(|name| {
        let word = name.find('.').unwrap_or(name.len());
        (0..=word).any(|end| name.get(end..).is_some_and(|rest| is_match(after, rest)))
    })
}

/// Returns a row of a table.
fn line(name: &str, row: &Value) -> String {
    let text = |field: &str| row[field].as_str().unwrap_or_default();
    let value = match &row["value"] {
        Value::Number(value) => format!("{} {}", number(value), text("unit").replace('_', " ")),
        other => other.as_str().unwrap_or_default().to_owned(),
    };
    let target = row["target"].as_number().map(number).unwrap_or_default();
    let verdict = match row["holds"].as_bool() {
        Some(true) => "holds".to_owned(),
        Some(false) => format!("**does not hold**: {}", text("reason")),
        None if row["noisy"] == true => "noisy".to_owned(),
        None => String::new(),
    };
    format!("| `{name}` | {value} | {target} | {verdict} |\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::row::Row;

    fn stored() -> Stored {
        let mut stored = Stored::default();
        let rows = [
            Row::lower("slave.flash", 76_124, "bytes").within(73_728),
            Row::lower("slave.flash.od", 1_000, "bytes"),
            Row::lower("slave.ram", 14_660, "bytes").within(16_384),
            Row::higher("speed", 2.9, "frames_per_second").noisy(),
        ];
        stored.replace("size", &rows, "rustc 1", "c0ffee").unwrap();
        stored
    }

    #[test]
    fn section_becomes_a_table_of_its_rows() {
        let page = "# Title\n\n<!-- rows: size.*.ram size.*.flash size.speed toolchain -->\nold\n<!-- end of rows -->\nText\n";
        let expected = "# Title

<!-- rows: size.*.ram size.*.flash size.speed toolchain -->

| row | value | target | |
| --- | --- | --- | --- |
| `size.slave.ram` | 14 660 bytes | 16 384 | holds |
| `size.slave.flash` | 76 124 bytes | 73 728 | **does not hold**:  |
| `size.speed` | 2.9 frames per second |  | noisy |
| `toolchain` | rustc 1 |  |  |

<!-- end of rows -->
Text
";
        let made = with_tables(page, &stored()).unwrap();
        assert_eq!(made, expected);
        assert_eq!(with_tables(&made, &stored()).unwrap(), expected, "again");
    }

    #[test]
    fn star_stands_for_letters_up_to_a_dot() {
        for (pattern, name, expected) in [
            ("rx.*", "rx.inside_look", true),
            ("rx.*_accelerated", "rx.inside_look_accelerated", true),
            ("rx.*_accelerated", "rx.inside_look", false),
            ("size.*.flash", "size.slave.flash.od", false),
            ("size.*.*.flash", "size.pyboard-v11.slave.flash", true),
            ("size.*", "size.slave.ram", false),
            ("irq.cut_bus", "irq.cut_bus_error", false),
        ] {
            assert_eq!(is_match(pattern, name), expected, "{pattern} {name}");
        }
    }

    #[test]
    fn section_without_an_end_is_refused() {
        let error = with_tables("<!-- rows: rx.* -->\ntext\n", &stored()).unwrap_err();
        assert!(error.to_string().contains("no line '<!-- end of rows -->'"), "{error}");
    }

    /// Given the pages and the stored rows of the repository, then the tables of each page have these rows.
    #[test]
    fn pages_are_as_stored() {
        let stored = Stored::read(&crate::bench::stored::path()).unwrap();
        for name in [PAGE, DETAILS] {
            let page = fs::read_to_string(project::path(name)).unwrap();
            let expected = with_tables(&page, &stored).unwrap();
            let differs = page.lines().zip(expected.lines()).find(|(page, expected)| page != expected);
            assert!(
                page == expected,
                "{name}: `cargo xtask bench --store` writes the tables; first difference: {differs:?}"
            );
        }
    }

    #[test]
    fn row_with_a_target_is_in_one_table_of_the_details() {
        let stored = Stored::read(&crate::bench::stored::path()).unwrap();
        let page = fs::read_to_string(project::path(DETAILS)).unwrap();
        let patterns: Vec<_> = page.lines().filter_map(patterns).flat_map(str::split_whitespace).collect();
        for (name, _) in stored.rows().filter(|(_, row)| row.get("target").is_some()) {
            assert_eq!(patterns.iter().filter(|pattern| is_match(pattern, name)).count(), 1, "{name}");
        }
    }
}
