//! The tests that carry the tag of a requirement, as commands: they must notice a patch that violates it.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::process::{Command, Output};

use anyhow::{Context, bail};

use super::copy;
use crate::compliance::{Summary, Tag, Target};

/// Longest run of the tests of a target, in seconds, with the images that they build. What runs longer has not found the defect.
const LIMIT: &str = "600";
/// Exit code of `timeout` when the time is over.
const TIMED_OUT: &str = "exit status: 124";

/// Tests of one target.
#[derive(Debug, PartialEq, Eq)]
pub struct Run<'tags> {
    target: &'tags Target,
    /// As libtest prints them.
    tests: Vec<String>,
}

/// How the tests ended on patched code.
#[derive(Debug, PartialEq, Eq)]
pub enum Ending {
    /// All passed.
    Passed,
    /// This one failed, perhaps others too.
    Failed(String),
    /// The run says nothing about the defect, for this reason.
    Useless(&'static str),
}

/// Returns the runs for a requirement: its own tests, then those of the clauses that it sums up. Of each, targets of a package with one of
/// the `changed` files come first. Targets of later tiers are left out.
pub fn runs<'tags>(
    id: &str,
    tags: &'tags [Tag],
    summaries: &[Summary],
    changed: &[String],
) -> Vec<Run<'tags>> {
    let is_summed_up = |tag: &Tag| {
        let has = |own: &String| summaries.iter().any(|summary| summary.id == id && summary.has(own));
        tag.ids.iter().chain(&tag.of_module).any(has)
    };
    let mut found = BTreeMap::<_, Run<'_>>::new();
    for tag in tags.iter().filter(|tag| tag.runs) {
        let Some(place) = tag.target.place else { continue };
        let is_own = tag.names(id);
        if !is_own && !is_summed_up(tag) {
            continue;
        }
        let is_of = |file: &&String| Path::new(file).starts_with(&tag.target.folder);
        // The longest folder: packages are inside of others.
        let nearness = changed.iter().find(is_of).map_or(0, |_| tag.target.folder.len());
        let order = (Reverse(is_own), Reverse(nearness), place, &tag.target.options);
        let run = found.entry(order).or_insert(Run { target: &tag.target, tests: Vec::new() });
        run.tests.push(tag.test());
    }
    found.into_values().collect()
}

impl Run<'_> {
    /// Compiles the patched code in `tree`, and runs the tests.
    ///
    /// # Errors
    /// When cargo cannot be run, or does not find each of the tests.
    pub fn attempt(&self, tree: &Path, target: &Path) -> anyhow::Result<Ending> {
        let build = cargo(tree, target).args(self.selection()).arg("--no-run").output();
        if !build.context("cannot run cargo")?.status.success() {
            return Ok(Ending::Useless("it does not compile"));
        }
        let limit =
            format!("target.'cfg(all())'.runner = ['timeout', '--foreground', '--kill-after=5', '{LIMIT}']");
        let mut run = cargo(tree, target);
        run.args(["--config", &limit]).args(self.selection()).args(["--", "--exact"]).args(&self.tests);
        self.ending(&run.output().context("cannot run cargo")?)
    }

    /// Reads how the tests ended from the output of cargo.
    fn ending(&self, output: &Output) -> anyhow::Result<Ending> {
        let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        // Of an image that a test builds.
        if [&out, &err].iter().any(|text| text.contains("error: could not compile")) {
            return Ok(Ending::Useless("it does not compile"));
        }
        if err.contains(TIMED_OUT) {
            return Ok(Ending::Useless("the tests did not end"));
        }
        let line = |line: &str| {
            let (test, state) = line.strip_prefix("test ")?.rsplit_once(" ... ")?;
            let name = test.split_once(" - ").map_or(test, |(name, _)| name);
            Some((name.to_owned(), state.trim() == "ok"))
        };
        let ended: BTreeMap<String, bool> = out.lines().filter_map(line).collect();
        if !out.lines().any(|line| line.starts_with("test result: ")) {
            if out.lines().any(|line| line.starts_with("running ")) {
                return Ok(Ending::Useless("the tests crashed"));
            }
            bail!("no test ran: cargo test {self}:\n{err}");
        }
        if let Some(missing) = self.tests.iter().find(|test| !ended.contains_key(*test)) {
            bail!("there is no test {missing}: cargo test {self}");
        }
        let failed = ended.into_iter().find(|(_, has_passed)| !has_passed);
        Ok(failed.map_or(Ending::Passed, |(test, _)| Ending::Failed(test)))
    }

    /// Returns package and target, as options of cargo.
    pub fn target(&self) -> String {
        format!("-p {} {}", self.target.package, self.target.options.join(" "))
    }

    /// Arguments of `cargo test` that select the target.
    fn selection(&self) -> impl Iterator<Item = &str> {
        let options = self.target.options.iter().map(String::as_str);
        ["--profile", "mutants", "-p", &self.target.package].into_iter().chain(options)
    }
}

impl fmt::Display for Run<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let selection: Vec<&str> = self.selection().collect();
        write!(f, "{} -- --exact {}", selection.join(" "), self.tests.join(" "))
    }
}

/// `cargo test` in the patched tree.
fn cargo(tree: &Path, target: &Path) -> Command {
    let mut cargo = copy::cargo(tree, target);
    cargo.arg("test");
    cargo
}

#[cfg(test)]
mod tests;
