//! Shards: parts of a long run that is divided among many machines.
//!
//! A *run* has units in a fixed order, such as the runs of a campaign. A *shard* `I/N` takes one range of them, the same on every
//! machine, and writes its results to a file, its *part*. [`merged`] joins the parts of all shards in the order of their units:
//!
//! ```text
//! shard.check("campaign", total, "runs")?;
//! shard::prepare("campaign", &path)?;
//! let results = fly(shard.share(total));
//! Part { run, shard: shard.index, results }.write(&path)?;
//!
//! let (run, results) = shard::merged("campaign", &files)?;
//! ```

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::str::FromStr;

use anyhow::{Context, bail};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::images::support::misuse::Misuse;
use crate::images::support::output;
use crate::images::support::project;

/// Greatest number of shards.
const MOST: u64 = 10_000_000;

/// One of several parts of a run: `3/16`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the shard, from 1.
    pub index: u64,
    /// Number of shards of the run.
    pub count: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let numbers = text.split_once('/').map(|(index, count)| (index.parse(), count.parse()));
        match numbers {
            Some((Ok(index), Ok(count))) if 1 <= index && index <= count && count <= MOST => {
                Ok(Shard { index, count })
            }
            _ => Err(format!("allowed are I/N with I from 1 to N and N up to {MOST}, for example 3/16")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.index, self.count)
    }
}

impl Shard {
    /// Refuses more shards than units: some would be empty. `units` is their name.
    ///
    /// # Errors
    /// [`Misuse`] of `command`.
    pub fn check(self, command: &'static str, total: u64, units: &str) -> Result<(), Misuse> {
        let Shard { count, .. } = self;
        if count <= total {
            return Ok(());
        }
        let text = format!(
            "--shard: {count} shards of {total} {units} leave some without any; allowed are 1 to {total} shards"
        );
        Err(Misuse::of(command, text))
    }

    /// The units of this shard, of `total`, from 0. Shards have equal numbers of units, or one more.
    pub fn share(self, total: u64) -> Range<u64> {
        let first = |shard: u64| (u128::from(total) * u128::from(shard) / u128::from(self.count)) as u64;
        first(self.index - 1)..first(self.index)
    }

    /// Name of the file of its part: `host-3-of-16.json` for `host`.
    pub fn file(self, of: &str) -> String {
        format!("{of}-{}-of-{}.json", self.index, self.count)
    }
}

/// A run that shards share. Parts belong together when all of this is equal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Run<P> {
    /// Name of the command, for example `campaign`.
    pub command: String,
    /// The code that ran, see [`commit`].
    pub commit: String,
    /// Number of shards.
    pub shards: u64,
    /// Parameters that determine the results, in addition to the code: an object.
    pub parameters: P,
}

/// Results of a shard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part<P, R> {
    /// Run of the shard.
    pub run: Run<P>,
    /// Number of the shard, from 1.
    pub shard: u64,
    /// Results of its units.
    pub results: R,
}

impl<P: Serialize, R: Serialize> Part<P, R> {
    /// Writes the file atomically.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let failure = || format!("cannot write {}", path.display());
        let text = serde_json::to_string_pretty(self)? + "\n";
        let unfinished = unfinished(path);
        fs::write(&unfinished, text).with_context(failure)?;
        fs::rename(&unfinished, path).with_context(failure)
    }
}

/// Checks that the part of a shard can be written to `path`. Removes the part of an earlier run, so that a shard that
/// fails leaves none.
///
/// # Errors
/// [`Misuse`] of `command`.
pub fn prepare(command: &'static str, path: &Path) -> Result<(), Misuse> {
    // The probe has the name of the shard: others prepare in the same folder at the same time.
    let probe = unfinished(path);
    let folder = path.parent().unwrap_or(Path::new(""));
    let remove = || if path.exists() { fs::remove_file(path) } else { Ok(()) };
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&probe, []))
        .and_then(|()| fs::remove_file(&probe))
        .and_then(|()| remove())
        .map_err(|cause| {
            let text =
                format!("--out: cannot write {}: {cause}; give a place that can be written", path.display());
            Misuse::of(command, text)
        })
}

fn unfinished(path: &Path) -> PathBuf {
    path.with_extension("unfinished")
}

/// Returns the version of this project: `git describe`, with `-dirty` when files differ from the commit; `unknown`
/// without git.
pub fn commit() -> String {
    let git = Command::new("git")
        .args(["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"])
        .current_dir(project::path(""))
        .output();
    let text = git.ok().filter(|output| output.status.success()).map(|output| output.stdout);
    text.and_then(|text| String::from_utf8(text).ok()).map_or("unknown".into(), |text| text.trim().to_owned())
}

/// Reads the parts of all shards of a run of `command`. The results are in the order of the shards.
///
/// # Errors
/// When a file is no part of this command, a part is of another run than the first one, or a shard is there twice or missing.
/// The error lists all of these.
pub fn merged<P, R>(command: &str, files: &[PathBuf]) -> anyhow::Result<(Run<P>, Vec<R>)>
where
    P: DeserializeOwned,
    R: DeserializeOwned,
{
    let mut problems = Vec::new();
    let mut first: Option<(&Path, Run<Value>)> = None;
    let mut parts: BTreeMap<u64, (&Path, R)> = BTreeMap::new();
    for path in files.iter().map(PathBuf::as_path) {
        let shown = path.display();
        let (run, shard, results) = match read(command, path) {
            Ok(part) => part,
            Err(problem) => {
                problems.push(format!("{shown}: {problem}"));
                continue;
            }
        };
        let (of, expected) = first.get_or_insert_with(|| (path, run.clone()));
        if let Some(text) = expected.difference(&run) {
            problems.push(format!("{shown}: of another run than {}: {text}", of.display()));
        } else if let Some((other, _)) = parts.get(&shard) {
            let other = other.display();
            problems.push(format!("{shown}: shard {shard} is already in {other}; give each once"));
        } else {
            parts.insert(shard, (path, results));
        }
    }
    let count = first.as_ref().map_or(0, |(_, run)| run.shards);
    let missing: Vec<String> =
        (1..=count).filter(|shard| !parts.contains_key(shard)).map(|shard| shard.to_string()).collect();
    if !missing.is_empty() {
        problems.push(format!("of {count} shards these are missing: {}", missing.join(", ")));
    }
    let run = match first {
        Some((_, run)) if problems.is_empty() => run,
        _ => bail!("these files are not the parts of one run:\n  {}", problems.join("\n  ")),
    };
    let Run { command, commit, shards, parameters } = run;
    if commit.ends_with("-dirty") || commit == "unknown" {
        output::warn(format_args!("commit {commit}: nothing shows that all shards ran the same code"));
    }
    let parameters = serde_json::from_value(parameters).context("parameters of the run")?;
    let results = parts.into_values().map(|(_, results)| results).collect();
    Ok((Run { command, commit, shards, parameters }, results))
}

/// Reads a part: its run, its number and its results.
fn read<R: DeserializeOwned>(command: &str, path: &Path) -> Result<(Run<Value>, u64, R), String> {
    let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
    let refuse = |error: serde_json::Error| format!("no part of a run of `{command}`: {error}");
    let Part { run, shard, results }: Part<Value, Value> = serde_json::from_str(&text).map_err(refuse)?;
    if run.command != command {
        return Err(format!("a part of a run of `{}`, not of `{command}`", run.command));
    }
    if !(1..=run.shards.min(MOST)).contains(&shard) {
        return Err(format!("shard {shard} of {}: allowed are 1 to N of N up to {MOST}", run.shards));
    }
    Ok((run, shard, serde_json::from_value(results).map_err(refuse)?))
}

impl Run<Value> {
    /// The first difference, in words: `seed 1 there, 2 here`.
    fn difference(&self, here: &Run<Value>) -> Option<String> {
        let fields = |run: &Run<Value>| {
            let mut fields = vec![
                ("commit".to_owned(), Value::from(run.commit.as_str())),
                ("number of shards".to_owned(), run.shards.into()),
            ];
            let parameters = run.parameters.as_object().into_iter().flatten();
            fields.extend(parameters.map(|(name, value)| (name.replace('_', " "), value.clone())));
            fields
        };
        let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let there = fields(self);
        let differing = there.iter().zip(fields(here)).find(|(there, here)| *there != here);
        let described = differing
            .map(|((name, there), (_, here))| format!("{name} {} there, {} here", text(there), text(&here)));
        described.or_else(|| (self != here).then(|| "other parameters".to_owned()))
    }
}

#[cfg(test)]
mod tests;
