//! A deliberate defect as a patch file, with a head that says how it is found.
//!
//! A *patch* is a unified diff against the root of the repository. The lines before the diff have one of two forms, each line once, in
//! any order. A patch that violates a requirement of the standard has `Verifies: 8.3.3h`, its id, and the defect in a sentence:
//! `Defect: The slave toggles one consumer time early.`
//!
//! One of the tests with the tag of that requirement must fail on the patched code. Any other patch names a command:
//!
//! ```text
//! Rule: lost-minority
//! Defect: The master does not try the other bus for a few lost slaves.
//! Command: cargo test --profile mutants -p ecss-can-cli --test campaign patches
//! Finds: lost-minority: the master is on Nominal, all slaves are reached on the other bus
//! ```
//!
//! The command must fail on the patched code, and its output must contain the text of `Finds`: a command that fails for another
//! reason has not found the defect.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;

/// Keys of the head, of both forms.
const KEYS: [&str; 5] = ["Verifies", "Rule", "Defect", "Command", "Finds"];
/// Keys of the form with a command that the other form lacks.
const OF_COMMAND: [&str; 3] = ["Rule", "Command", "Finds"];

/// A patch file.
#[derive(Debug, PartialEq, Eq)]
pub struct Patch {
    /// Absolute path.
    pub file: PathBuf,
    /// Files that the diff changes, from the root of the repository.
    pub changed: Vec<String>,
    pub head: Head,
}

/// How a defect is found.
#[derive(Debug, PartialEq, Eq)]
pub struct Head {
    /// The defect, in a sentence.
    pub defect: String,
    pub finder: Finder,
}

/// What must find a defect.
#[derive(Debug, PartialEq, Eq)]
pub enum Finder {
    /// A test with the tag of this requirement, by failing.
    Tests { requirement: String },
    /// A command, by failing with a text.
    Command {
        /// Name of the rule that is broken.
        rule: String,
        /// Arguments of cargo.
        arguments: Vec<String>,
        /// Part of the output of the command.
        finds: String,
    },
}

impl Head {
    /// Reads the lines before the diff.
    ///
    /// # Errors
    /// The first line that is wrong, or the first key that is missing.
    pub fn parse(text: &str) -> Result<Head, String> {
        let mut values = BTreeMap::new();
        let is_diff = |line: &&str| line.starts_with("diff --git ") || line.starts_with("--- ");
        for line in text.lines().take_while(|line| !is_diff(line)).filter(|line| !line.trim().is_empty()) {
            let entry = line.split_once(": ").filter(|(key, _)| KEYS.contains(key));
            let (key, value) = entry.ok_or_else(|| {
                format!("{line:?} is not allowed before the diff; allowed are {}", allowed())
            })?;
            if values.insert(key, value.trim()).is_some() {
                return Err(format!("two lines \"{key}: ...\"; allowed is one"));
            }
        }
        let value = |key| {
            let found = values.get(key).filter(|value| !value.is_empty()).map(|value| (*value).to_owned());
            found.ok_or_else(|| format!("no line \"{key}: ...\" before the diff"))
        };
        if !values.contains_key("Verifies") && !values.contains_key("Rule") {
            return Err("no line \"Verifies: ...\" or \"Rule: ...\" before the diff".to_owned());
        }
        if values.contains_key("Verifies") {
            if let Some(other) = OF_COMMAND.iter().find(|key| values.contains_key(*key)) {
                return Err(format!(
                    "\"{other}: ...\" beside \"Verifies: ...\" before the diff: the tag selects the tests; allowed is one form"
                ));
            }
            let finder = Finder::Tests { requirement: value("Verifies")? };
            return Ok(Head { defect: value("Defect")?, finder });
        }
        let (rule, defect, command, finds) =
            (value("Rule")?, value("Defect")?, value("Command")?, value("Finds")?);
        let mut words = command.split_whitespace().map(str::to_owned);
        if words.next().as_deref() != Some("cargo") {
            return Err(format!("the command {command:?} does not begin with \"cargo\""));
        }
        Ok(Head { defect, finder: Finder::Command { rule, arguments: words.collect(), finds } })
    }

    /// Returns the requirement or the rule that the patch breaks.
    pub fn name(&self) -> &str {
        match &self.finder {
            Finder::Tests { requirement } => requirement,
            Finder::Command { rule, .. } => rule,
        }
    }
}

fn allowed() -> String {
    KEYS.map(|key| format!("\"{key}: ...\"")).join(", ")
}

/// Returns the files that a diff changes: those of its lines `--- a/file` and `+++ b/file`.
fn changed(diff: &str) -> Vec<String> {
    let named = diff.lines().filter_map(|line| line.strip_prefix("--- a/").or(line.strip_prefix("+++ b/")));
    let mut files: Vec<String> = named.map(|file| file.trim_end().to_owned()).collect();
    files.dedup();
    files
}

impl Patch {
    /// Reads a patch file.
    ///
    /// # Errors
    /// The file and what is wrong with it.
    pub fn read(file: &Path) -> Result<Patch, String> {
        let wrong = |text: String| format!("{}: {text}", file.display());
        let text = std::fs::read(file).map_err(|error| wrong(error.to_string()))?;
        // The diff may have any encoding: git reads it.
        let text = String::from_utf8_lossy(&text);
        let head = Head::parse(&text).map_err(wrong)?;
        let file = file.canonicalize().map_err(|error| wrong(error.to_string()))?;
        Ok(Patch { file, changed: changed(&text), head })
    }

    /// Applies the patch to the tree in `root`, or with `--check` among the `options` only tries to. Returns what git says if the patch
    /// does not apply.
    ///
    /// # Errors
    /// When git cannot be run.
    pub fn apply(&self, root: &Path, options: &[&str]) -> anyhow::Result<Result<(), String>> {
        let mut git = Command::new("git");
        git.arg("apply").args(options).arg(&self.file).current_dir(root);
        // In a folder of another repository git would take paths from the root of that, and skip all files.
        if let Some(above) = root.parent() {
            git.env("GIT_CEILING_DIRECTORIES", above);
        }
        let output = git.output().context("cannot run git")?;
        let complaint = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        Ok(if output.status.success() { Ok(()) } else { Err(complaint) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "Rule: a-rule\nDefect: It does not hold.\nCommand: cargo test -p a\nFinds: a: b\n";

    #[test]
    fn head_ends_at_the_diff() {
        let head = Head::parse(&format!("{HEAD}\ndiff --git a/a b/a\n--- a/a\n+++ b/a\nRule: of the diff\n"));
        let finder = Finder::Command {
            rule: "a-rule".into(),
            arguments: ["test", "-p", "a"].map(str::to_owned).to_vec(),
            finds: "a: b".into(),
        };
        assert_eq!(head, Ok(Head { defect: "It does not hold.".into(), finder }));
    }

    #[test]
    fn head_may_name_a_requirement_instead_of_a_command() {
        let head = Head::parse("Verifies: 8.3.3h\nDefect: It does not hold.\n\n--- a/a\n");
        let finder = Finder::Tests { requirement: "8.3.3h".into() };
        assert_eq!(head, Ok(Head { defect: "It does not hold.".into(), finder }));
    }

    #[test]
    fn changed_files_are_those_of_both_sides_of_the_diff() {
        let diff = "--- a/one\n+++ b/one\n@@ -1 +1 @@\n-a\n+b\n--- /dev/null\n+++ b/two\n--- a/three\n+++ /dev/null\n";
        assert_eq!(changed(diff), ["one", "two", "three"]);
    }

    #[test]
    fn wrong_head_is_refused_with_what_is_allowed() {
        for (text, expected) in [
            ("", "no line \"Verifies: ...\" or \"Rule: ...\" before the diff".to_owned()),
            ("Verifies: 8.3.3h\n", "no line \"Defect: ...\"".to_owned()),
            (&format!("Verifies: 8.3.3h\n{HEAD}"), "\"Rule: ...\" beside \"Verifies: ...\"".to_owned()),
            ("Verifies: 1a\nDefect: It.\nFinds: a\n", "\"Finds: ...\" beside".to_owned()),
            (&HEAD.replace("Finds: a: b\n", "--- a\nFinds: a\n"), "no line \"Finds: ...\"".to_owned()),
            (&HEAD.replace("a-rule", " "), "no line \"Rule: ...\"".to_owned()),
            (&format!("{HEAD}Rule: b\n"), "two lines \"Rule: ...\"".to_owned()),
            (&format!("{HEAD}Found: b\n"), "\"Found: b\" is not allowed".to_owned()),
            (&format!("some text\n{HEAD}"), "\"some text\" is not allowed".to_owned()),
            (&HEAD.replace("cargo test", "rm"), "does not begin with \"cargo\"".to_owned()),
        ] {
            let error = Head::parse(text).expect_err(text);
            assert!(error.contains(&expected), "{text}: {error}");
        }
    }
}
