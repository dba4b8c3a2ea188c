//! Mission files (TOML): a flight with its boards, images, places, crystals, faults and criteria.
//!
//! A file gives the same [`Options`] as the command line, so that both make the same plan. Options that were given replace the entries
//! of the file. `docs/mission-file.md` describes the keys.

mod nodes;
mod schema;
mod source;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use can_twin::description;
use can_twin::model::Part;
use can_twin::wire::time::Time;
use clap::ValueEnum;
use schema::File;
use source::Source;
use toml::{Spanned, Value};

use super::criterion::{Criterion, Must};
use super::fault::{self, TimedCommand};
use super::options::{CutAt, Options, SECONDS};
use crate::images::support::board::{Board, Profile};
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{LAST, MASTER};

/// Allowed times of criteria, seconds.
const TIMES: std::ops::RangeInclusive<f64> = 0.0..=3_600.0;

/// Allowed bounds of a clock, microseconds.
const CLOCKS_US: std::ops::RangeInclusive<f64> = 0.001..=1_000_000.0;

/// Reads a mission file into options, except those in `given`. Returns the fields of the options that it has set.
///
/// # Errors
/// When the file cannot be read, or has a mistake: file, line, key, and what is allowed.
pub fn apply(
    path: &Path,
    options: &mut Options,
    given: &BTreeSet<String>,
) -> Result<BTreeSet<String>, Misuse> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        let cause = format!("{error}; give a mission file (TOML)");
        Misuse::value("fly", "[FILE]", path.display(), cause)
    })?;
    let source = Source { path, text: &text };
    let file = source.read()?;
    let mut reader = Reader { source, options, given, set: BTreeSet::new() };
    reader.boards(&file)?;
    reader.length(&file)?;
    nodes::apply(&mut reader, &file)?;
    reader.faults(&file)?;
    reader.criteria(&file)?;
    Ok(reader.set)
}

/// Transfers a file to options.
struct Reader<'a> {
    source: Source<'a>,
    options: &'a mut Options,
    given: &'a BTreeSet<String>,
    set: BTreeSet<String>,
}

impl Reader<'_> {
    /// Returns whether an entry of the file counts, and notes that it sets `field`.
    fn takes(&mut self, field: &str) -> bool {
        let is_free = !self.given.contains(field);
        if is_free {
            self.set.insert(field.to_owned());
        }
        is_free
    }

    /// Returns the text of a value as something else.
    fn parsed<T>(
        &self,
        value: &Spanned<String>,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, Misuse> {
        let text = value.get_ref();
        parse(text).map_err(|cause| self.source.wrong(&value.span(), format!("'{text}': {cause}")))
    }

    /// Returns a path of the file, which is relative to the folder of the file.
    fn path(&self, value: &Spanned<String>) -> PathBuf {
        self.source.path.parent().unwrap_or(Path::new("")).join(value.get_ref())
    }

    fn boards(&mut self, file: &File) -> Result<(), Misuse> {
        if let Some(board) = &file.board {
            let folder = self.path(board);
            let parse = |text: &str| {
                Board::parse(if folder.exists() { folder.to_str().unwrap_or(text) } else { text })
            };
            let parsed = self.parsed(board, parse)?;
            if self.takes("board") {
                self.options.fleet.target.board = parsed;
            }
        }
        if let Some(profile) = &file.profile {
            let names: Vec<&str> = Profile::value_variants().iter().map(|profile| profile.name()).collect();
            let allowed = format!("no such profile; allowed are {}", names.join(", "));
            let parsed =
                self.parsed(profile, |text| Profile::from_str(text, false).map_err(|_| allowed.clone()))?;
            if self.takes("profile") {
                self.options.fleet.target.profile = parsed;
            }
        }
        if let Some(chip) = &file.chip {
            let part = self.parsed(chip, |text| Part::named(text).map_err(|error| error.to_string()))?;
            if self.takes("chip") {
                self.options.fleet.chip = Some(part);
            }
        }
        if let Some(oscillator) = &file.oscillator {
            let parse = |text: &str| description::oscillator(text).map_err(|error| error.to_string());
            let parsed = self.parsed(oscillator, parse)?;
            if self.takes("oscillator") {
                self.options.fleet.oscillator = Some(parsed);
            }
        }
        for (value, field, most) in [
            (&file.slaves, "slaves", 14),
            (&file.minimal, "minimal", 13),
            (&file.one_controller, "one_controller", 13),
        ] {
            let Some(value) = value else { continue };
            let number = self.source.within(value, &(0..=most), "")? as u8;
            if self.takes(field) {
                match field {
                    "slaves" => self.options.fleet.slaves = number,
                    "minimal" => self.options.minimal = number,
                    _ => self.options.one_controller = number,
                }
            }
        }
        Ok(())
    }

    fn length(&mut self, file: &File) -> Result<(), Misuse> {
        if let Some(seconds) = &file.seconds {
            let seconds = self.source.within(seconds, &SECONDS, " s")?;
            if self.takes("seconds") {
                self.options.seconds = seconds;
            }
        }
        if let Some(seed) = &file.seed {
            let seed = self.source.within(seed, &(0..=i64::MAX), "")? as u64;
            if self.takes("seed") {
                self.options.seed = seed;
            }
        }
        if let Some(cut_at) = &file.cut_at {
            let text = match cut_at.get_ref() {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            let parsed: CutAt = text
                .parse()
                .map_err(|cause| self.source.wrong(&cut_at.span(), format!("{text}: {cause}")))?;
            if !self.given.contains("faults") && self.takes("cut_at") {
                self.options.cut_at = Some(parsed);
            }
        }
        Ok(())
    }

    fn faults(&mut self, file: &File) -> Result<(), Misuse> {
        let mut faults = Vec::new();
        for fault in &file.fault {
            let second = self.source.within(&fault.at, &(0.0..=*SECONDS.end()), " s")?;
            let command = self.parsed(&fault.command, fault::command)?;
            faults.push(TimedCommand { second, command, origin: self.source.origin(&fault.command.span()) });
        }
        let has_others = ["faults", "cut_at"].iter().any(|field| self.given.contains(*field));
        if !faults.is_empty() && !has_others {
            self.options.faults = faults;
        }
        Ok(())
    }

    fn criteria(&mut self, file: &File) -> Result<(), Misuse> {
        for criterion in &file.criterion {
            let nodes = match &criterion.nodes {
                None => {
                    self.options.nodes().into_iter().filter(|node| *node > MASTER && *node <= LAST).collect()
                }
                Some(nodes) => self.node_ids(nodes)?,
            };
            let time =
                |value| Ok(Time::from_us((1e6 * self.source.within(value, &TIMES, " s")?).round() as u64));
            let mut musts = Vec::new();
            if let Some(value) = &criterion.operational_at {
                musts.push((value.span(), Must::OperationalAt(time(value)?)));
            }
            if let Some(value) = &criterion.fail_over_within {
                musts.push((value.span(), Must::FailOverWithin(time(value)?)));
            }
            if let Some(value) = &criterion.answer_within {
                musts.push((value.span(), Must::AnswerWithin(time(value)?)));
            }
            if let Some(value) = &criterion.clock_within_us {
                let most = self.source.within(value, &CLOCKS_US, " us")?;
                musts.push((value.span(), Must::ClockWithin(most)));
            }
            if let Some(value) = criterion.operational_at_end.as_ref().filter(|value| !value.get_ref()) {
                musts.push((value.span(), Must::MayBeLost));
            }
            for (span, must) in musts {
                let of = |node| Criterion { node, must, origin: self.source.origin(&span) };
                self.options.criteria.extend(nodes.iter().copied().map(of));
            }
        }
        Ok(())
    }

    fn node_ids(&self, nodes: &Spanned<Vec<i64>>) -> Result<Vec<u8>, Misuse> {
        let wrong = |node: i64| {
            let cause = format!("{node} is no Node-ID; allowed are {MASTER} to {LAST}");
            self.source.wrong(&nodes.span(), cause)
        };
        let of = |node: &i64| {
            u8::try_from(*node).ok().filter(|id| (MASTER..=LAST).contains(id)).ok_or_else(|| wrong(*node))
        };
        nodes.get_ref().iter().map(of).collect()
    }
}
