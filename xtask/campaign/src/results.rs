//! Results of a campaign or of a shard of it: written, merged, printed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::{Deserialize, Serialize};
use support::misuse::Misuse;

use crate::kind::Kind;
use crate::outcome::Outcome;
use crate::script::Script;

/// What was asked for: shards belong together where these are the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// `git describe` of the code, with `-dirty` where files differed.
    pub commit: String,
    /// Of the scripts.
    pub seed: u64,
    /// Of all shards together.
    pub runs: u64,
    /// Where they fly.
    pub world: String,
    /// Masters in each run. Files from before there were two do not say it.
    #[serde(default = "one")]
    pub masters: u8,
    /// Number of shards.
    pub shards: u64,
}

fn one() -> u8 {
    1
}

/// Results of some runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Of which campaign.
    pub asked: Asked,
    /// Which shards these are, from 1.
    pub parts: BTreeSet<u64>,
    /// Runs flown.
    pub flown: u64,
    /// Of them with two faults.
    pub double: u64,
    /// Of them those in which no fault changed a frame or a state.
    pub idle: u64,
    /// Virtual time, microseconds.
    pub virtual_us: u64,
    /// Of each kind: planned, and those that changed a frame or a state.
    pub kinds: BTreeMap<String, (u64, u64)>,
    /// From a fault to the change of the bus by the master, microseconds, ascending.
    pub detections: Vec<u64>,
    /// Runs that violated something.
    pub violations: Vec<Violation>,
}

/// A run that violated something.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violation {
    /// Number of the run.
    pub run: u64,
    /// What was violated.
    pub reasons: Vec<String>,
    /// The script as it was flown, then as simple as it could be made.
    pub script: String,
    /// Empty where it was not shrunk.
    pub shrunk: String,
}

impl Results {
    /// Of no run yet.
    pub fn new(asked: Asked, part: u64) -> Results {
        Results {
            asked,
            parts: BTreeSet::from([part]),
            flown: 0,
            double: 0,
            idle: 0,
            virtual_us: 0,
            kinds: Kind::ALL.iter().map(|(_, name)| ((*name).to_owned(), (0, 0))).collect(),
            detections: Vec::new(),
            violations: Vec::new(),
        }
    }

    /// Adds a run.
    pub fn add(&mut self, run: u64, script: &Script, outcome: Outcome) {
        self.flown += 1;
        self.double += u64::from(script.faults.len() > 1);
        self.idle += u64::from(!outcome.effective.contains(&true));
        self.virtual_us += script.length;
        for (index, fault) in script.faults.iter().enumerate() {
            let count = self.kinds.entry(fault.kind.name().to_owned()).or_default();
            count.0 += 1;
            count.1 += u64::from(outcome.effective.get(index).is_some_and(|has_effect| *has_effect));
        }
        self.detections.extend(outcome.detections);
        if !outcome.violations.is_empty() {
            let (reasons, script) = (outcome.violations, script.to_string());
            self.violations.push(Violation { run, reasons, script, shrunk: String::new() });
        }
    }

    /// Puts what was added in another order into that of the runs: equal campaigns give equal files.
    pub fn sort(&mut self) {
        self.detections.sort_unstable();
        self.violations.sort_by_key(|violation| violation.run);
    }

    /// Writes a file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        std::fs::write(path, text).with_context(|| format!("writing {}", path.display()))
    }

    /// Joins the shards of a campaign.
    ///
    /// # Errors
    /// [`Misuse`] when a file is no result, when two are of different campaigns, or when a shard is there twice or missing.
    pub fn merged(files: &[PathBuf]) -> Result<Results, Misuse> {
        let refuse = |text: String| Misuse::of("campaign", text);
        let mut all: Option<(&PathBuf, Results)> = None;
        for path in files {
            let text = std::fs::read_to_string(path)
                .map_err(|error| refuse(format!("{}: {error}", path.display())))?;
            let part: Results = serde_json::from_str(&text).map_err(|error| {
                refuse(format!("{}: no results of `cargo xtask campaign`: {error}", path.display()))
            })?;
            all = Some(match all {
                None => (path, part),
                Some((first, mut sum)) => {
                    if let Some(text) = sum.asked.difference(&part.asked) {
                        let (first, path) = (first.display(), path.display());
                        return Err(refuse(format!(
                            "{first} and {path} are of different campaigns: {text}; merge shards of one commit, seed, number \
                             of runs, world and number of masters"
                        )));
                    }
                    if let Some(twice) = part.parts.intersection(&sum.parts).next() {
                        return Err(refuse(format!(
                            "{}: shard {twice} is there twice; give each once",
                            path.display()
                        )));
                    }
                    sum.join(part);
                    (first, sum)
                }
            });
        }
        let (_, mut sum) = all.ok_or_else(|| refuse("no files; give the results of all shards".into()))?;
        let missing: Vec<String> = (1..=sum.asked.shards)
            .filter(|part| !sum.parts.contains(part))
            .map(|part| part.to_string())
            .collect();
        if !missing.is_empty() {
            let shards = sum.asked.shards;
            return Err(refuse(format!(
                "of {shards} shards these are missing: {}; give all of them",
                missing.join(", ")
            )));
        }
        sum.sort();
        Ok(sum)
    }

    fn join(&mut self, part: Results) {
        self.parts.extend(part.parts);
        self.flown += part.flown;
        self.double += part.double;
        self.idle += part.idle;
        self.virtual_us += part.virtual_us;
        for (kind, (planned, effective)) in part.kinds {
            let count = self.kinds.entry(kind).or_default();
            *count = (count.0 + planned, count.1 + effective);
        }
        self.detections.extend(part.detections);
        self.violations.extend(part.violations);
    }

    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("{:<16} {:>9} {:>12}", "fault", "planned", "took effect")];
        for (kind, (planned, effective)) in &self.kinds {
            lines.push(format!("{kind:<16} {planned:>9} {effective:>12}"));
        }
        let Results { flown, double, idle, asked, .. } = self;
        let masters = if asked.masters == 1 { "one master" } else { "two masters" };
        lines.push(String::new());
        lines.push(format!(
            "{flown} runs in world {} with {masters}, {double} of them with two faults, {idle} without effect, {:.1} h of virtual time; \
             seed {}, {}",
            asked.world,
            self.virtual_us as f64 / 3.6e9,
            asked.seed,
            asked.commit
        ));
        if let (Some(median), Some(last)) =
            (self.detections.get(self.detections.len() / 2), self.detections.last())
        {
            lines.push(format!(
                "{} changes of the bus after a fault: median {:.1} ms, longest {:.1} ms",
                self.detections.len(),
                *median as f64 / 1e3,
                *last as f64 / 1e3
            ));
        }
        for violation in &self.violations {
            lines.push(format!("\nrun {} violates:", violation.run));
            lines.extend(violation.reasons.iter().map(|reason| format!("  {reason}")));
            let script = if violation.shrunk.is_empty() { &violation.script } else { &violation.shrunk };
            lines.push("fly it with --replay FILE:".into());
            lines.push(script.trim_end().to_owned());
        }
        lines.push(format!("{} violations", self.violations.len()));
        lines
    }
}

impl Asked {
    /// What differs, in words.
    fn difference(&self, other: &Asked) -> Option<String> {
        let fields = [
            ("commit", self.commit.clone(), other.commit.clone()),
            ("seed", self.seed.to_string(), other.seed.to_string()),
            ("runs", self.runs.to_string(), other.runs.to_string()),
            ("world", self.world.clone(), other.world.clone()),
            ("masters", self.masters.to_string(), other.masters.to_string()),
            ("number of shards", self.shards.to_string(), other.shards.to_string()),
        ];
        let differing = fields.into_iter().find(|(_, one, two)| one != two);
        differing.map(|(name, one, two)| format!("{name} {one} and {two}"))
    }
}
