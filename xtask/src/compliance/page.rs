//! The page: both tables as Markdown.

use std::fmt::Write as _;

use super::check::Tests;
use super::requirements::{Clause, Interpretation, Kind, Requirement, Summary, Who};
use super::tags::Tag;

const HEAD: &str = "# Compliance

Written by `cargo xtask compliance`; do not edit. `cargo xtask compliance --check` fails if a tag names no requirement, stands on
no test that runs, or a requirement on software has no test of the first tier that is known to notice a violation.

A requirement that sums up others is verified by its own tests and by those of the clauses that it sums up, named in italics.

A doc comment \"Notices: ECSS 8.3.3h: ...\" at a test names a violation that makes it fail. For each requirement at least one was tried;
others follow from the assertions.

Three columns say how the software interprets a requirement. Their links lead to the decisions.

* reading: the text is unclear, or contradicts another one, and we take it in one way.
* extension: we meet the text and do more than it asks for.
* deviation: we do not do what the text says (ECSS-S-ST-00-01C). Your customer has to agree.

";

const BEFORE_CLAUSES: &str = "
## Table 11-1: what applies of CiA 301

A applicable, O optional, NA not used, R for reference, as the standard has it.

| section | subject | | we have | why less or more |
| --- | --- | --- | --- | --- |
";

/// How many requirements there are, how many are traced and noticed, and how many have each kind of interpretation, in a line.
pub fn summary(requirements: &[Requirement], interpretations: &[Interpretation], tags: &[Tag]) -> String {
    let number = |who: Who| requirements.iter().filter(|row| row.who == who).count();
    let software = || requirements.iter().filter(|row| row.who == Who::Software);
    let traced = software().filter(|row| Tests::of(row, tags).number > 0).count();
    let tried = software().filter(|row| Tests::of(row, tags).notice).count();
    let of_kind =
        |kind| requirements.iter().filter(|row| of(interpretations, row, kind).next().is_some()).count();
    format!(
        "{} requirements: {} on software ({traced} traced to tests, {tried} of them with a violation that was tried and noticed), {} on boards, {} on the integrator, {} tailored; \
         {} with a deviation, {} with an extension, {} with a reading",
        requirements.len(),
        number(Who::Software),
        number(Who::Board),
        number(Who::Integrator),
        number(Who::Tailored),
        of_kind(Kind::Deviation),
        of_kind(Kind::Extension),
        of_kind(Kind::Reading),
    )
}

/// How many requirements on software have one test, two, three, or more, and how many have one of the first tier, in a line.
pub fn tests_per_requirement(requirements: &[Requirement], tags: &[Tag]) -> String {
    let software = requirements.iter().filter(|row| row.who == Who::Software);
    let of_each: Vec<_> = software.map(|row| Tests::of(row, tags)).collect();
    let with = |such: &dyn Fn(usize) -> bool| of_each.iter().filter(|tests| such(tests.number)).count();
    format!(
        "Requirements on software by number of tests: {} with one, {} with two, {} with three, {} with more; {} have a test of the first \
         tier (`cargo test`)",
        with(&|number| number == 1),
        with(&|number| number == 2),
        with(&|number| number == 3),
        with(&|number| number > 3),
        of_each.iter().filter(|tests| tests.of_first_tier > 0).count(),
    )
}

/// The whole page.
pub fn write(
    requirements: &[Requirement],
    interpretations: &[Interpretation],
    summaries: &[Summary],
    clauses: &[Clause],
    tags: &[Tag],
) -> String {
    let mut page = HEAD.to_owned();
    let _ = writeln!(page, "{}.", summary(requirements, interpretations, tags));
    let _ = writeln!(page, "\n{}.", tests_per_requirement(requirements, tags));
    let mut chapter = "";
    for row in requirements {
        let own = row.id.split('.').next().unwrap_or_default();
        if own != chapter {
            chapter = own;
            let columns =
                ["id", "requirement", "who", "tests", "reading", "extension", "deviation", "remark"];
            let _ = write!(page, "\n## Clause {own}\n\n| {} |\n", columns.join(" | "));
            let _ = writeln!(page, "| {} |", columns.map(|_| "---").join(" | "));
        }
        let mut tests = links(row, tags);
        tests.extend(summaries.iter().filter(|summary| summary.id == row.id).map(summed_up));
        let ours = |kind: Kind| of(interpretations, row, kind).map(decision).collect::<Vec<_>>().join("<br>");
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} | {} | {} | {} |",
            row.id,
            row.text,
            format!("{:?}", row.who).to_lowercase(),
            tests.join("<br>"),
            ours(Kind::Reading),
            ours(Kind::Extension),
            ours(Kind::Deviation),
            row.remark
        );
    }
    page.push_str(BEFORE_CLAUSES);
    for row in clauses {
        let Clause { section, subject, applicability, ours, reason } = row;
        let _ = writeln!(page, "| {section} | {subject} | {applicability} | {ours} | {reason} |");
    }
    page
}

/// The interpretations of a requirement that are of this kind.
fn of<'a>(
    all: &'a [Interpretation],
    row: &Requirement,
    kind: Kind,
) -> impl Iterator<Item = &'a Interpretation> {
    all.iter().filter(move |one| one.id == row.id && one.kind == kind)
}

/// The tests that name a requirement, in their order. Those whose module names it are one link.
fn links(row: &Requirement, tags: &[Tag]) -> Vec<String> {
    let named: Vec<&Tag> = tags.iter().filter(|tag| tag.runs && tag.names(&row.id)).collect();
    let mut links = Vec::new();
    for tests in named.chunk_by(|one, next| one.file == next.file) {
        let (of_module, alone): (Vec<&Tag>, Vec<&Tag>) =
            tests.iter().partition(|tag| tag.of_module.contains(&row.id));
        if let [first, ..] = of_module.as_slice() {
            let name = first.file.rsplit("tests/").next().unwrap_or(&first.file);
            links.push(format!("all {} of [{name}](../{})", of_module.len(), first.file));
        }
        links.extend(alone.into_iter().map(link));
    }
    links
}

/// What stands behind the tests of a requirement that sums up others.
fn summed_up(summary: &Summary) -> String {
    format!("*and the tests of {}: {}*", summary.clauses.replace(' ', ", "), summary.reason)
}

fn decision(interpretation: &Interpretation) -> String {
    format!("{} [Decision]({})", interpretation.text, interpretation.page)
}

/// To the file alone: lines move too often.
fn link(tag: &Tag) -> String {
    format!("[{}](../{})", tag.function, tag.file)
}
