//! `cargo xtask compliance`: each requirement of the standard, who meets it, and the tests that verify it.
//!
//! Requirements are rows of `xtask/compliance/data/requirements.csv`, in our own words. A test names what it verifies in its doc comment:
//! `Verifies: ECSS 8.3.3h`. Both together are the matrix of `docs/compliance.md`: whether each requirement applies, its [`status`], its
//! method of verification and the evidence. Deviations, extensions and readings have tables of their own, from `data/interpretations.csv`.
//! A requirement that sums up others, as a row of Table 5-2 does, is a row of `data/summaries.csv` too: the tests of those clauses verify
//! it beside its own. The last table of the page is `data/table_11_1.csv`: what Table 11-1 says of each part of CiA 301, and what we have
//! of it.

mod check;
mod counts;
mod page;
mod requirements;
mod sources;
mod status;
mod tags;
#[cfg(test)]
mod tests;

use std::fs;

use anyhow::{Context, bail};
use check::{check, check_interpretations, check_pages, check_summaries};
use clap::Args;
use ecss_can_cli::images::support::output;
use ecss_can_cli::images::support::project::path;
pub use requirements::{Summary, summaries};
use requirements::{Who, clauses, interpretations, requirements};
use sources::read_all;
pub use tags::{Tag, Target};

/// The page that it writes, from the root of the repository.
const PAGE: &str = "docs/compliance.md";
/// Folder of the pages that interpretations name.
const DOCS: &str = "docs";

/// Command line of `compliance`.
#[derive(Args, Debug)]
pub struct Options {
    /// Write nothing; exit with 1 if the page is old, a tag is wrong or no test notices a violation of a requirement on software
    #[arg(long)]
    check: bool,
}

/// Names and numbers of what the table has: all requirements, and those on software.
pub fn numbers() -> [(&'static str, usize); 2] {
    [("all", requirements().len()), ("software", of_software().len())]
}

/// Ids of the requirements on software, in the order of the standard.
pub fn of_software() -> Vec<String> {
    requirements().into_iter().filter(|row| row.who == Who::Software).map(|row| row.id).collect()
}

/// Tags of all sources of the project.
///
/// # Errors
/// A source that cannot be read or is not Rust.
pub fn tags() -> anyhow::Result<Vec<Tag>> {
    read_all(&path("."))
}

/// Writes the page, or checks it. Prints how many requirements are traced.
///
/// # Errors
/// A source or table that cannot be read; a page that cannot be written; with `--check` everything that is wrong.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let requirements = requirements();
    let tags = tags()?;
    let mut findings = check(&requirements, &tags);
    findings.extend(check_interpretations(&requirements, &interpretations(), &path(DOCS)));
    findings.extend(check_pages(&requirements, &path(DOCS)));
    findings.extend(check_summaries(&requirements, &summaries()));
    let text = page::write(&requirements, &interpretations(), &summaries(), &clauses(), &tags);
    let page = path(PAGE);
    output::line(counts::summary(&requirements, &interpretations(), &tags))?;
    output::line(counts::tests_per_requirement(&requirements, &tags))?;
    if !options.check {
        fs::write(&page, text).with_context(|| format!("cannot write {}", page.display()))?;
        findings.iter().for_each(output::warn);
        return Ok(());
    }
    if fs::read_to_string(&page).ok() != Some(text) {
        findings.push(format!("{PAGE} is not what `cargo xtask compliance` would write"));
    }
    findings.iter().for_each(output::complain);
    match findings.len() {
        0 => Ok(()),
        number => bail!("{number} findings; see above"),
    }
}
