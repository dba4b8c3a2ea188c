//! What is wrong with tags and requirements.

use std::collections::BTreeMap;
use std::path::Path;

use super::requirements::{Interpretation, Requirement, Who};
use super::tags::Tag;

/// A test that names more verifies none of them well.
const MOST: usize = 5;

/// A sentence for everything that is wrong, tags first.
pub fn check(requirements: &[Requirement], tags: &[Tag]) -> Vec<String> {
    let mut tests: BTreeMap<&str, usize> = requirements.iter().map(|row| (row.id.as_str(), 0)).collect();
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
        for id in tag.noticed.iter().filter(|id| !tag.ids.contains(id)) {
            findings.push(format!("{at}: {} notices {id}, which it does not verify", tag.function));
        }
        for id in &tag.ids {
            match tests.get_mut(id.as_str()) {
                Some(number) => *number += usize::from(tag.runs),
                None => findings.push(format!("{at}: there is no requirement {id}")),
            }
        }
    }
    findings.extend(rows(requirements));
    let untested = |row: &&Requirement| row.who == Who::Software && tests.get(row.id.as_str()) == Some(&0);
    findings.extend(requirements.iter().filter(untested).map(|row| format!("{}: no test names it", row.id)));
    findings
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

fn rows(requirements: &[Requirement]) -> impl Iterator<Item = String> {
    requirements.iter().enumerate().filter_map(|(number, row)| {
        let is_double = requirements.iter().take(number).any(|other| other.id == row.id);
        let names_clause = row.remark.contains(|letter: char| letter.is_ascii_digit());
        let reason = if is_double {
            "it has two rows"
        } else if row.text.is_empty() {
            "what it asks for is not said"
        } else if row.who == Who::Tailored && !names_clause {
            "tailored without a clause that permits it"
        } else if matches!(row.who, Who::Board | Who::Integrator) && row.remark.is_empty() {
            "not met by software, and no reason"
        } else {
            return None;
        };
        Some(format!("{}: {reason}", row.id))
    })
}
