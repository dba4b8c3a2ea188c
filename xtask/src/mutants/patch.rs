//! A deliberate defect as a patch file, with a head that says how it is found.
//!
//! A *patch* is a unified diff against the root of the repository. These lines are before the diff, each once, in any order:
//!
//! ```text
//! Rule: lost-minority
//! Defect: The master does not try the other bus for a few lost slaves.
//! Command: cargo test --profile mutants -p campaign --test campaign patches
//! Finds: lost-minority: the master is on Nominal, all slaves are reached on the other bus
//! ```
//!
//! The command must fail on the patched code, and its output must contain the text of `Finds`: a command that fails for another
//! reason has not found the defect.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;

/// Keys of the head.
const KEYS: [&str; 4] = ["Rule", "Defect", "Command", "Finds"];

/// A patch file.
#[derive(Debug, PartialEq, Eq)]
pub struct Patch {
    /// Absolute path.
    pub file: PathBuf,
    pub head: Head,
}

/// How a defect is found.
#[derive(Debug, PartialEq, Eq)]
pub struct Head {
    /// Name of the rule that is broken.
    pub rule: String,
    /// The defect, in a sentence.
    pub defect: String,
    /// Arguments of cargo.
    pub command: Vec<String>,
    /// Part of the output of the command.
    pub finds: String,
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
            let found = values.get(key).filter(|value| !value.is_empty());
            found.copied().ok_or_else(|| format!("no line \"{key}: ...\" before the diff"))
        };
        let [rule, defect, command, finds] = KEYS.map(value);
        let (rule, defect, command, finds) = (rule?, defect?, command?, finds?);
        let mut words = command.split_whitespace().map(str::to_owned);
        if words.next().as_deref() != Some("cargo") {
            return Err(format!("the command {command:?} does not begin with \"cargo\""));
        }
        Ok(Head {
            rule: rule.to_owned(),
            defect: defect.to_owned(),
            command: words.collect(),
            finds: finds.to_owned(),
        })
    }
}

fn allowed() -> String {
    KEYS.map(|key| format!("\"{key}: ...\"")).join(", ")
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
        let head = Head::parse(&String::from_utf8_lossy(&text)).map_err(wrong)?;
        let file = file.canonicalize().map_err(|error| wrong(error.to_string()))?;
        Ok(Patch { file, head })
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
        let expected = Head {
            rule: "a-rule".into(),
            defect: "It does not hold.".into(),
            command: ["test", "-p", "a"].map(str::to_owned).to_vec(),
            finds: "a: b".into(),
        };
        assert_eq!(head, Ok(expected));
    }

    #[test]
    fn wrong_head_is_refused_with_what_is_allowed() {
        for (text, expected) in [
            ("", "no line \"Rule: ...\" before the diff".to_owned()),
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
