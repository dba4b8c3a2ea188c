//! The page: both tables as Markdown.

use std::fmt::Write as _;

use super::requirements::{Clause, Deviation, Requirement, Who};
use super::tags::Tag;

const HEAD: &str = "# Compliance

Written by `cargo xtask compliance`; do not edit. `cargo xtask compliance --check` fails if a tag names no requirement, stands on
no test that runs, or a requirement on software has no test.

The column \"deviation\" says where we do something else than the text, or read an unclear text in one way. Its link leads to the
decision.

";

const BEFORE_CLAUSES: &str = "
## Table 11-1: what applies of CiA 301

A applicable, O optional, NA not used, R for reference, as the standard has it.

| section | subject | | we have | deviation and reason |
| --- | --- | --- | --- | --- |
";

/// How many requirements there are and how many are traced, in a line.
pub fn summary(requirements: &[Requirement], tags: &[Tag]) -> String {
    let number = |who: Who| requirements.iter().filter(|row| row.who == who).count();
    let software = || requirements.iter().filter(|row| row.who == Who::Software);
    let traced = software().filter(|row| tests(row, tags).next().is_some()).count();
    format!(
        "{} requirements: {} on software ({traced} traced to tests), {} on boards, {} on the integrator, {} tailored",
        requirements.len(),
        number(Who::Software),
        number(Who::Board),
        number(Who::Integrator),
        number(Who::Tailored),
    )
}

/// The whole page.
pub fn write(
    requirements: &[Requirement],
    deviations: &[Deviation],
    clauses: &[Clause],
    tags: &[Tag],
) -> String {
    let mut page = HEAD.to_owned();
    let _ = writeln!(page, "{}.", summary(requirements, tags));
    let mut chapter = "";
    for row in requirements {
        let own = row.id.split('.').next().unwrap_or_default();
        if own != chapter {
            chapter = own;
            let _ = write!(
                page,
                "\n## Clause {own}\n\n| id | requirement | who | tests | deviation | remark |\n"
            );
            page.push_str("| --- | --- | --- | --- | --- | --- |\n");
        }
        let tests: Vec<String> = tests(row, tags).map(link).collect();
        let own = deviations.iter().filter(|deviation| deviation.id == row.id);
        let deviations: Vec<String> = own.map(decision).collect();
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} | {} |",
            row.id,
            row.text,
            row.who,
            tests.join("<br>"),
            deviations.join("<br>"),
            row.remark
        );
    }
    page.push_str(BEFORE_CLAUSES);
    for row in clauses {
        let Clause { section, subject, applicability, ours, deviation } = row;
        let _ = writeln!(page, "| {section} | {subject} | {applicability} | {ours} | {deviation} |");
    }
    page
}

fn tests<'t>(row: &'t Requirement, tags: &'t [Tag]) -> impl Iterator<Item = &'t Tag> {
    tags.iter().filter(|tag| tag.runs && tag.ids.contains(&row.id))
}

fn decision(deviation: &Deviation) -> String {
    format!("{} [Decision]({})", deviation.text, deviation.page)
}

/// To the file alone: lines move too often.
fn link(tag: &Tag) -> String {
    format!("[{}](../{})", tag.function, tag.file)
}
