//! What is wrong with tags and requirements.

use std::path::Path;

use super::requirements::{Applies, Interpretation, Method, Requirement, Summary, Who};
use super::tags::Tag;

/// A test that names more verifies none of them well.
const MOST: usize = 5;

/// Folders of tests that `cargo test` does not run.
const LATER_TIERS: [&str; 3] = ["tests/declarations/", "tests/search/", "tests/second/"];

/// A sentence for everything that is wrong, tags first.
pub fn check(requirements: &[Requirement], tags: &[Tag]) -> Vec<String> {
    let mut findings = Vec::new();
    for tag in tags {
        let at = format!("{}:{}", tag.file, tag.line);
        if !tag.runs {
            findings.push(format!("{at}: the tag is not on a test that runs"));
        }
        if tag.ids.len() > MOST {
            let (function, number) = (&tag.function, tag.ids.len());
            findings
                .push(format!("{at}: {function} names {number} requirements, at most {MOST} are allowed"));
        }
        for id in tag.ids.iter().filter(|id| tag.of_module.contains(id)) {
            findings.push(format!("{at}: {} names {id}, as its module does already", tag.function));
        }
        for id in tag.noticed.iter().filter(|id| !tag.names(id)) {
            findings.push(format!("{at}: {} notices {id}, which it does not verify", tag.function));
        }
        for id in
            tag.ids.iter().chain(&tag.of_module).filter(|id| requirements.iter().all(|row| row.id != **id))
        {
            findings.push(format!("{at}: there is no requirement {id}"));
        }
    }
    findings.extend(rows(requirements));
    findings.extend(requirements.iter().filter(|row| row.who == Who::Software).filter_map(|row| {
        let tests = Tests::of(row, tags);
        let reason = if tests.number == 0 {
            "no test names it"
        } else if tests.of_first_tier == 0 {
            "no test of the first tier names it"
        } else if !tests.notice {
            "no test that names it has a line `Notices:` for it"
        } else {
            return None;
        };
        Some(format!("{}: {reason}", row.id))
    }));
    findings
}

/// The tests that name a requirement.
pub struct Tests {
    pub number: usize,
    pub of_first_tier: usize,
    /// Whether one of them names a violation that makes it fail.
    pub notice: bool,
}

impl Tests {
    pub fn of(requirement: &Requirement, tags: &[Tag]) -> Tests {
        let named = || tags.iter().filter(|tag| tag.runs && tag.names(&requirement.id));
        let is_later = |tag: &&Tag| LATER_TIERS.iter().any(|folder| tag.file.starts_with(folder));
        Tests {
            number: named().count(),
            of_first_tier: named().filter(|tag| !is_later(tag)).count(),
            notice: named().any(|tag| tag.noticed.contains(&requirement.id)),
        }
    }
}

/// Requirements whose page is not in `docs`, and those on software with a page.
pub fn check_pages(requirements: &[Requirement], docs: &Path) -> Vec<String> {
    let wrong = requirements.iter().filter(|row| !row.page.is_empty()).filter_map(|row| {
        let file = row.page.split('#').next().unwrap_or_default();
        let reason = if row.who == Who::Software {
            "on software, and with a page in place of tests"
        } else if !docs.join(file).exists() {
            "its page is not in docs"
        } else {
            return None;
        };
        Some(format!("{}: {reason}", row.id))
    });
    wrong.collect()
}

/// Interpretations that name no requirement or no page of `docs`, or that are no sentence.
pub fn check_interpretations(
    requirements: &[Requirement],
    interpretations: &[Interpretation],
    docs: &Path,
) -> Vec<String> {
    let wrong = interpretations.iter().filter_map(|Interpretation { id, text, page, .. }| {
        let file = page.split('#').next().unwrap_or_default();
        let reason = if requirements.iter().all(|row| row.id != *id) {
            "its interpretation names no requirement"
        } else if text.is_empty() || !text.ends_with('.') {
            "its interpretation is no sentence"
        } else if !file.ends_with(".md") || !docs.join(file).is_file() {
            "its interpretation names no page of docs"
        } else {
            return None;
        };
        Some(format!("{id}: {reason}"))
    });
    wrong.collect()
}

/// Summaries of no requirement on software, of clauses without one, or without a sentence that says why.
pub fn check_summaries(requirements: &[Requirement], summaries: &[Summary]) -> Vec<String> {
    let software = || requirements.iter().filter(|row| row.who == Who::Software);
    let is_empty = |summary: &Summary| {
        summary.clauses.split(' ').any(|clause| {
            let one = Summary { clauses: clause.to_owned(), ..summary.clone() };
            clause.is_empty() || !software().any(|row| one.has(&row.id))
        })
    };
    let wrong = summaries.iter().filter_map(|summary| {
        let reason = if !software().any(|row| row.id == summary.id) {
            "its summary names no requirement on software"
        } else if summary.has(&summary.id) {
            "its summary names the requirement itself"
        } else if is_empty(summary) {
            "its summary names a clause without a requirement on software"
        } else if !summary.reason.ends_with('.') {
            "the reason of its summary is no sentence"
        } else {
            return None;
        };
        Some(format!("{}: {reason}", summary.id))
    });
    wrong.collect()
}

fn rows(requirements: &[Requirement]) -> impl Iterator<Item = String> {
    requirements.iter().enumerate().filter_map(|(number, row)| {
        let is_double = requirements.iter().take(number).any(|other| other.id == row.id);
        let names_clause = row.remark.contains(|letter: char| letter.is_ascii_digit());
        let reason = if is_double {
            "it has two rows"
        } else if row.text.is_empty() {
            "what it asks for is not said"
        } else if row.applies == Applies::No && !names_clause {
            "not applicable, and the remark names no clause that permits it"
        } else if row.method.is_some() != (row.applies == Applies::Yes) {
            "a requirement that applies has a method of verification, and only such a one"
        } else if row.who == Who::Software && row.method != Some(Method::T) {
            "on software, and not verified by test"
        } else if matches!(row.who, Who::Board | Who::Integrator) && row.remark.is_empty() {
            "not met by software, and no reason"
        } else {
            return None;
        };
        Some(format!("{}: {reason}", row.id))
    })
}
