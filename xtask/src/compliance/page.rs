//! The page: its tables as Markdown.

use std::fmt::Write as _;

use super::counts;
use super::requirements::{Clause, Interpretation, Kind, Requirement, Summary};
use super::status::Status;
use super::tags::Tag;

const HEAD: &str = "# Compliance

Written by `cargo xtask compliance`; do not edit. `cargo xtask compliance --check` fails if a tag names no requirement, stands on
no test that runs, or a requirement on software has no test of the first tier that is known to notice a violation.

This page covers the software of this repository on emulated boards. It claims nothing about a spacecraft:
[missing evidence](missing-evidence.md) lists what a project adds. Columns of the matrix:

* **on**: who meets the requirement: `software`, `board` (the hardware of a node) or `integrator` (harness, agreements, values).
* **applies**: `yes`; `no`, with the clause that permits it; `may`: a permission, so there is nothing to verify.
* **status**: `C` compliant, `P` partly compliant: see its [deviation](#deviations), `N` not compliant: no test verifies it, `open`: the
  integrator shows compliance.
* **method**: `T` test, `A` analysis, `R` review of design, `I` inspection (ECSS-E-ST-10-02). The integrator does what is `open`.
* **evidence**: tests, or a page that helps the integrator. A requirement that sums up others is verified by its own tests and by those of
  the clauses named in italics.
* **see**: tables below in which the software's reading, extension or deviation stands.

A doc comment \"Notices: ECSS 8.3.3h: ...\" at a test names a violation that makes it fail. For each requirement at least one was tried;
others follow from the assertions.

";

const BEFORE_CLAUSES: &str = "
## Table 11-1: what applies of CiA 301

A applicable, O optional, NA not used, R for reference, as the standard has it.

| section | subject | | we have | why less or more |
| --- | --- | --- | --- | --- |
";

/// Tables of interpretations in their order: kind, heading, link text, and the meaning of the kind.
const KINDS: [(Kind, &str, &str, &str); 3] = [
    (
        Kind::Deviation,
        "Deviations",
        "deviation",
        "We do not do all that the text says (deviation in the sense of ECSS-S-ST-00-01C). Your customer has to agree.",
    ),
    (Kind::Extension, "Extensions", "extension", "We meet the text and do more than it asks for."),
    (
        Kind::Reading,
        "Readings",
        "reading",
        "The text is unclear, or contradicts another one, and we take it in one way.",
    ),
];

/// The whole page.
pub fn write(
    requirements: &[Requirement],
    interpretations: &[Interpretation],
    summaries: &[Summary],
    clauses: &[Clause],
    tags: &[Tag],
) -> String {
    let mut page = HEAD.to_owned();
    let _ = writeln!(page, "{}.", counts::summary(requirements, interpretations, tags));
    let _ = writeln!(page, "\n{}.", counts::tests_per_requirement(requirements, tags));
    page.push_str(&counts::by_clause(requirements, interpretations, tags));
    let mut clause = "";
    for row in requirements {
        if row.clause() != clause {
            clause = row.clause();
            let columns =
                ["id", "requirement", "on", "applies", "status", "method", "evidence", "see", "remark"];
            let _ = write!(page, "\n## Clause {clause}\n\n| {} |\n", columns.join(" | "));
            let _ = writeln!(page, "| {} |", columns.map(|_| "---").join(" | "));
        }
        let mut evidence = links(row, tags);
        evidence.extend((!row.page.is_empty()).then(|| format!("[{0}]({0})", row.page)));
        evidence.extend(summaries.iter().filter(|summary| summary.id == row.id).map(summed_up));
        let see = KINDS.iter().filter(|kind| row.interpreted(interpretations, kind.0).next().is_some());
        let see = see.map(|(_, title, word, _)| format!("[{word}](#{})", title.to_lowercase()));
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            row.id,
            row.text,
            format!("{:?}", row.who).to_lowercase(),
            format!("{:?}", row.applies).to_lowercase(),
            Status::of(row, interpretations, tags).map_or("", Status::word),
            row.method.map_or(String::new(), |method| format!("{method:?}")),
            evidence.join("<br>"),
            see.collect::<Vec<_>>().join("<br>"),
            row.remark
        );
    }
    for (kind, title, _, meaning) in KINDS {
        let _ = write!(page, "\n## {title}\n\n{meaning}\n\n| id | what the software does | decision |\n");
        page.push_str("| --- | --- | --- |\n");
        for one in interpretations.iter().filter(|one| one.kind == kind) {
            let _ = writeln!(page, "| {} | {} | [page]({}) |", one.id, one.text, one.page);
        }
    }
    page.push_str(BEFORE_CLAUSES);
    for row in clauses {
        let Clause { section, subject, applicability, ours, reason } = row;
        let _ = writeln!(page, "| {section} | {subject} | {applicability} | {ours} | {reason} |");
    }
    page
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

/// To the file alone: lines move too often.
fn link(tag: &Tag) -> String {
    format!("[{}](../{})", tag.function, tag.file)
}
