//! Results of a campaign or of a shard of it: collected, joined, printed.

use std::collections::BTreeMap;

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::campaign::kind::Kind;
use crate::campaign::outcome::Outcome;
use crate::campaign::script::Script;
use crate::images::support::shard::Run;

/// Parameters of a campaign: they and the commit determine its results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Asked {
    /// Seed of the scripts.
    pub seed: u64,
    /// Number of runs of all shards together.
    pub runs: u64,
    /// World in which they run.
    pub world: String,
    /// Masters in each run.
    pub masters: u8,
    /// Kinds of the faults of each run. Empty: any.
    #[serde(default)]
    pub kinds: Vec<Kind>,
}

/// Results of some runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Number of runs.
    pub flown: u64,
    /// Runs with two faults.
    pub double: u64,
    /// Runs with two related faults.
    pub related: u64,
    /// Runs in which no fault had an effect.
    pub idle: u64,
    /// Virtual time, microseconds.
    pub virtual_us: u64,
    /// Number of faults of each kind: planned, and with an effect.
    pub kinds: BTreeMap<String, (u64, u64)>,
    /// Times from a fault to the change of the bus by the master, microseconds, ascending.
    pub detections: Vec<u64>,
    /// Runs with violations.
    pub violations: Vec<Violation>,
}

/// A run with violations.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Violation {
    /// Number of the run.
    pub run: u64,
    /// Violated conditions.
    pub reasons: Vec<String>,
    /// The script of the run.
    pub script: String,
    /// The simplest script found; empty if it was not shrunk.
    pub shrunk: String,
}

impl Results {
    /// Makes results without runs.
    pub fn empty() -> Results {
        Results {
            flown: 0,
            double: 0,
            related: 0,
            idle: 0,
            virtual_us: 0,
            kinds: Kind::value_variants().iter().map(|kind| (kind.name(), (0, 0))).collect(),
            detections: Vec::new(),
            violations: Vec::new(),
        }
    }

    /// Adds a run.
    pub fn add(&mut self, run: u64, script: &Script, outcome: Outcome) {
        self.flown += 1;
        self.double += u64::from(script.faults.len() > 1);
        self.related += u64::from(script.is_related());
        self.idle += u64::from(!outcome.effective.contains(&true));
        self.virtual_us += script.length;
        for (index, fault) in script.faults.iter().enumerate() {
            let count = self.kinds.entry(fault.kind.name()).or_default();
            count.0 += 1;
            count.1 += u64::from(outcome.effective.get(index).is_some_and(|has_effect| *has_effect));
        }
        self.detections.extend(outcome.detections);
        if !outcome.violations.is_empty() {
            let (reasons, script) = (outcome.violations, script.to_string());
            self.violations.push(Violation { run, reasons, script, shrunk: String::new() });
        }
    }

    /// Sorts results by the number of the run, so that equal campaigns give equal files.
    pub fn sort(&mut self) {
        self.detections.sort_unstable();
        self.violations.sort_by_key(|violation| violation.run);
    }

    /// Joins the results of all shards.
    pub fn joined(parts: Vec<Results>) -> Results {
        let mut sum = Results::empty();
        parts.into_iter().for_each(|part| sum.add_all(part));
        sum.sort();
        sum
    }

    fn add_all(&mut self, part: Results) {
        self.flown += part.flown;
        self.double += part.double;
        self.related += part.related;
        self.idle += part.idle;
        self.virtual_us += part.virtual_us;
        for (kind, (planned, effective)) in part.kinds {
            let count = self.kinds.entry(kind).or_default();
            *count = (count.0 + planned, count.1 + effective);
        }
        self.detections.extend(part.detections);
        self.violations.extend(part.violations);
    }

    /// Returns the results of this campaign as text.
    pub fn lines(&self, run: &Run<Asked>) -> Vec<String> {
        let mut lines = vec![format!("{:<16} {:>9} {:>12}", "fault", "planned", "took effect")];
        for (kind, (planned, effective)) in &self.kinds {
            lines.push(format!("{kind:<16} {planned:>9} {effective:>12}"));
        }
        let Results { flown, double, related, idle, .. } = self;
        let asked = &run.parameters;
        let masters = if asked.masters == 1 { "one master" } else { "two masters" };
        lines.push(String::new());
        lines.push(format!(
            "{flown} runs in world {} with {masters}, {double} of them with two faults, {related} with related ones, {idle} without effect, \
             {:.1} h of virtual time; \
             seed {}{}, {}",
            asked.world,
            self.virtual_us as f64 / 3.6e9,
            asked.seed,
            asked.kinds.iter().map(|kind| format!(", {}", kind.name())).collect::<String>(),
            run.commit
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
            lines.push("run it with --replay FILE:".into());
            lines.push(script.trim_end().to_owned());
        }
        lines.push(format!("{} violations", self.violations.len()));
        lines
    }
}
