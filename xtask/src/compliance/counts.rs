//! How many requirements there are: by who meets them, by status, by evidence.

use std::fmt::Write as _;

use super::check::Tests;
use super::requirements::{Applies, Interpretation, Kind, Requirement, Who};
use super::status::Status;
use super::tags::Tag;

/// Counts requirements by who meets them, by evidence, by status and by kind of interpretation, in one line.
pub fn summary(requirements: &[Requirement], interpretations: &[Interpretation], tags: &[Tag]) -> String {
    let number = |who: Who| requirements.iter().filter(|row| row.who == who).count();
    let software = || requirements.iter().filter(|row| row.who == Who::Software);
    let traced = software().filter(|row| Tests::of(row, tags).number > 0).count();
    let tried = software().filter(|row| Tests::of(row, tags).notice).count();
    let such = |applies: Applies| requirements.iter().filter(|row| row.applies == applies).count();
    let of_status = |status: Status| {
        requirements.iter().filter(|row| Status::of(row, interpretations, tags) == Some(status)).count()
    };
    let of_kind = |kind| {
        requirements.iter().filter(|row| row.interpreted(interpretations, kind).next().is_some()).count()
    };
    format!(
        "{} requirements: {} on software ({traced} traced to tests, {tried} of them with a violation that was tried and noticed), {} on \
         boards, {} on the integrator; {} do not apply, {} are permissions; {} compliant, {} partly, {} not, {} open; {} with a \
         deviation, {} with an extension, {} with a reading",
        requirements.len(),
        number(Who::Software),
        number(Who::Board),
        number(Who::Integrator),
        such(Applies::No),
        such(Applies::May),
        of_status(Status::C),
        of_status(Status::P),
        of_status(Status::N),
        of_status(Status::Open),
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

/// Status of the requirements by clause, as a table.
pub fn by_clause(requirements: &[Requirement], interpretations: &[Interpretation], tags: &[Tag]) -> String {
    let mut table = "\n| clause | C | P | N | open | does not apply | permission |\n".to_owned();
    table.push_str("| --- | --- | --- | --- | --- | --- | --- |\n");
    for rows in requirements.chunk_by(|one, next| one.clause() == next.clause()) {
        let of_status =
            |status| rows.iter().filter(|row| Status::of(row, interpretations, tags) == Some(status)).count();
        let such = |applies| rows.iter().filter(|row| row.applies == applies).count();
        let statuses = [Status::C, Status::P, Status::N, Status::Open].map(of_status);
        let cells = statuses.into_iter().chain([Applies::No, Applies::May].map(such));
        let cells: Vec<String> = cells.map(|count| count.to_string()).collect();
        let _ = writeln!(table, "| {} | {} |", rows[0].clause(), cells.join(" | "));
    }
    table
}
