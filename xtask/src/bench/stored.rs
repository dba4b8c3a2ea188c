//! Figures in `xtask/bench/stored.json`, so that changes of them are noticed.
//!
//! The file has rows as `summary.json` has them: `"area.name": {...}`, and a row `toolchain`. A row that misses its
//! target has a `reason`, which is written manually. A row of [`RATCHETED`] also has its `best` value of this compiler,
//! and an `accepted` value with the reason why it may be worse:
//!
//! ```text
//! "best": { "value": 300.007, "commit": "e80fd9b2" },
//! "accepted": { "value": 319.129, "reason": "a node that notes SYNCs also counts those that are not captured" }
//! ```
//!
//! [`Stored::findings`] compares a run with it, and `page` makes the tables of the documentation from it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use ecss_can_cli::images::support::project;
use serde_json::{Value, json};

use super::Measured;
use super::row::{Better, Row};

/// Largest difference from the stored value that is not reported, as a share of it.
const TOLERANCE: f64 = 0.03;

/// Areas whose rows are compared with the best value of their compiler, so that they cannot degrade in small steps.
const RATCHETED: [&str; 3] = ["size", "instructions", "rx"];

/// The row that names the compiler of the images.
const TOOLCHAIN: &str = "toolchain";

/// Field of a row: its best value of this compiler, and the commit that had it.
const BEST: &str = "best";

/// Field of a row: a value that is worse than the best one, and the reason for it.
const ACCEPTED: &str = "accepted";

/// The stored rows, by area and name: `rx.interrupt_to_dictionary`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stored {
    rows: BTreeMap<String, Value>,
}

/// Returns the path of the file.
pub fn path() -> PathBuf {
    project::path("xtask/bench/stored.json")
}

impl Stored {
    /// Reads the file.
    ///
    /// # Errors
    /// When it is missing or no JSON object.
    pub fn read(path: &Path) -> anyhow::Result<Stored> {
        let failure = || format!("cannot read {}", path.display());
        let text = fs::read_to_string(path).with_context(failure)?;
        Ok(Stored { rows: serde_json::from_str(&text).with_context(failure)? })
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(&self.rows)? + "\n";
        fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
    }

    /// Returns the compiler of the measured images.
    pub fn compiler(&self) -> Option<&str> {
        self.rows.get(TOOLCHAIN)?.get("value")?.as_str()
    }

    /// Returns all rows by name, including that of the compiler.
    pub fn rows(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.rows.iter().map(|(name, row)| (name.as_str(), row))
    }

    /// Replaces the rows of an area, measured on `commit`. The reason of a row stays as long as its target does not hold, and an
    /// accepted value as long as the row is worse than its best one. Best values of another compiler are dropped, in all areas.
    ///
    /// # Errors
    /// When a row is no JSON.
    pub fn replace(&mut self, area: &str, rows: &[Row], compiler: &str, commit: &str) -> anyhow::Result<()> {
        if self.compiler() != Some(compiler) {
            for row in self.rows.values_mut().filter_map(Value::as_object_mut) {
                row.remove(BEST);
                row.remove(ACCEPTED);
            }
        }
        let before = self.rows.clone();
        self.rows.retain(|key, _| !is_of(area, key));
        for row in rows {
            let key = format!("{area}.{}", row.name);
            let mut value = serde_json::to_value(row)?;
            let stored = before.get(&key).unwrap_or(&Value::Null);
            if let Some(reason) = stored.get("reason")
                && row.holds == Some(false)
            {
                value["reason"] = reason.clone();
            }
            if is_ratcheted(area, row) {
                ratchet(&mut value, stored, row, commit);
            }
            self.rows.insert(key, value);
        }
        self.rows.insert(TOOLCHAIN.into(), toolchain(compiler));
        Ok(())
    }

    /// Compares the rows of an area with the stored ones. Returns a sentence for each relevant difference.
    pub fn findings(&self, area: &str, rows: &[Row]) -> Vec<String> {
        let measured: Vec<String> = rows.iter().map(|row| format!("{area}.{}", row.name)).collect();
        let differing = measured.iter().zip(rows).filter_map(|(key, row)| self.finding(area, key, row));
        let missing = self.rows.keys().filter(|key| is_of(area, key) && !measured.contains(key));
        differing.chain(missing.map(|key| format!("{key} is stored but was not measured"))).collect()
    }

    fn finding(&self, area: &str, key: &str, row: &Row) -> Option<String> {
        let Row { value, unit, .. } = row;
        let Some(stored) = self.rows.get(key) else {
            return Some(format!("{key} is not stored"));
        };
        let (now, before) = (value.as_f64()?, stored.get("value")?.as_f64()?);
        let target = row.target.as_ref().map(ToString::to_string).unwrap_or_default();
        if row.holds == Some(false) {
            if stored["holds"] == true {
                return Some(format!("{key} is {value} {unit}: its target {target} held before"));
            }
            if reason(stored).is_none() {
                return Some(format!(
                    "{key} is {value} {unit}: its target {target} does not hold, without a reason"
                ));
            }
        }
        let worse = is_ratcheted(area, row).then(|| worse_than_best(key, stored, row)).flatten();
        let differs = !row.noisy && (now - before).abs() > TOLERANCE * before.abs();
        worse.or_else(|| differs.then(|| format!("{key} is {value} {unit}: {before} is stored")))
    }
}

/// Returns the rows of a run in the form of the file, without data of earlier runs.
///
/// # Errors
/// When a row is no JSON.
pub fn as_json(Measured { areas, compiler }: &Measured) -> anyhow::Result<Value> {
    let mut json = json!({ TOOLCHAIN: toolchain(compiler) });
    for (area, row) in areas.iter().flat_map(|(area, rows)| rows.iter().map(move |row| (area, row))) {
        json[format!("{area}.{}", row.name)] = serde_json::to_value(row)?;
    }
    Ok(json)
}

fn toolchain(compiler: &str) -> Value {
    json!({ "value": compiler, "unit": "compiler of the images" })
}

/// Returns whether a row is compared with its best value.
fn is_ratcheted(area: &str, row: &Row) -> bool {
    RATCHETED.contains(&area) && !row.noisy
}

/// Returns by how much `now` is worse than another value of its row.
fn loss(row: &Row, now: f64, other: f64) -> f64 {
    match row.better {
        Better::Lower => now - other,
        Better::Higher => other - now,
    }
}

/// Returns whether `now` is worse than another value of its row by more than the tolerance.
fn is_worse(row: &Row, now: f64, other: f64) -> bool {
    loss(row, now, other) > TOLERANCE * other.abs()
}

/// Returns the reason of a value, if there is one.
fn reason(value: &Value) -> Option<&str> {
    value["reason"].as_str().filter(|reason| !reason.is_empty())
}

/// Returns the number `value` within a field of a stored row.
fn value_of(stored: &Value, field: &str) -> Option<f64> {
    stored.get(field)?.get("value")?.as_f64()
}

/// Adds the best and the accepted value to a row that is stored anew.
fn ratchet(value: &mut Value, stored: &Value, row: &Row, commit: &str) {
    let Some(now) = row.value.as_f64() else { return };
    match value_of(stored, BEST) {
        Some(best) if loss(row, now, best) >= 0.0 => {
            value[BEST] = stored[BEST].clone();
            if let Some(accepted) = value_of(stored, ACCEPTED)
                && is_worse(row, now, best)
            {
                value[ACCEPTED] = stored[ACCEPTED].clone();
                // An improvement must not be lost unnoticed.
                if loss(row, now, accepted) < 0.0 {
                    value[ACCEPTED]["value"] = row.value.clone().into();
                }
            }
        }
        _ => value[BEST] = json!({ "value": row.value, "commit": commit }),
    }
}

/// Returns a sentence if a row is worse than its best value by more than the tolerance, and worse than its accepted
/// value.
fn worse_than_best(key: &str, stored: &Value, row: &Row) -> Option<String> {
    let (now, best) = (row.value.as_f64()?, value_of(stored, BEST)?);
    if !is_worse(row, now, best) {
        return None;
    }
    let accepted = value_of(stored, ACCEPTED).filter(|_| reason(&stored[ACCEPTED]).is_some());
    if accepted.is_some_and(|accepted| !is_worse(row, now, accepted)) {
        return None;
    }
    let Row { value, unit, .. } = row;
    let commit = stored[BEST]["commit"].as_str().unwrap_or("unknown");
    let known = accepted.map(|accepted| format!(", {accepted} is accepted")).unwrap_or_default();
    Some(format!(
        "{key} is {value} {unit}: its best is {best}, of commit {commit}{known}; improve it, or write `accepted` with value and \
         reason into its row"
    ))
}

fn is_of(area: &str, key: &str) -> bool {
    key.split_once('.').is_some_and(|(of, _)| of == area)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: &str = "rx";
    const KEY: &str = "rx.latency";

    fn row(value: u64) -> Row {
        Row::lower("latency", value, "model_cycles").within(1_500)
    }

    fn stored(row: Row) -> Stored {
        let mut stored = Stored::default();
        stored.replace(AREA, &[row], "rustc 1", "c0ffee").unwrap();
        stored
    }

    fn with_reason(row: Row) -> Stored {
        let mut stored = stored(row);
        stored.rows.get_mut(KEY).unwrap()["reason"] = "the heartbeat comes first".into();
        stored
    }

    #[test]
    fn rows_that_differ_or_miss_their_target_are_found() {
        let noisy = |value| row(value).noisy();
        for (stored, measured, expected) in [
            (stored(row(1_000)), row(1_000), None),
            (stored(row(1_000)), row(1_030), None),
            (stored(row(1_000)), row(969), Some("is 969 model_cycles: 1000 is stored")),
            (with_reason(row(2_000)), row(2_000), None),
            (stored(row(1_490)), row(1_501), Some("is 1501 model_cycles: its target 1500 held before")),
            (
                stored(row(2_000)),
                row(2_000),
                Some("is 2000 model_cycles: its target 1500 does not hold, without a reason"),
            ),
            // Noise may differ, but holds its target.
            (stored(noisy(1_000)), noisy(1_500), None),
            (stored(noisy(1_000)), noisy(1_501), Some("is 1501 model_cycles: its target 1500 held before")),
        ] {
            let expected: Vec<_> = expected.iter().map(|text| format!("{KEY} {text}")).collect();
            assert_eq!(stored.findings(AREA, std::slice::from_ref(&measured)), expected, "{measured:?}");
        }
        let mut others = Stored::default();
        others.replace("irq", &[row(1_000)], "rustc 1", "c0ffee").unwrap();
        for value in [969, 1_031] {
            let expected = format!("irq.latency is {value} model_cycles: 1000 is stored");
            assert_eq!(others.findings("irq", &[row(value)]), [expected]);
        }
    }

    #[test]
    fn rows_on_one_side_alone_are_found() {
        let other = Row::lower("other", 1, "model_cycles");
        let findings = stored(row(1_000)).findings(AREA, &[other]);
        assert_eq!(findings, ["rx.other is not stored", "rx.latency is stored but was not measured"]);
        assert_eq!(stored(row(1_000)).findings("tx", &[]), [""; 0]);
    }

    #[test]
    fn reason_stays_while_the_target_does_not_hold() {
        let mut rows = with_reason(row(2_000));
        rows.replace(AREA, &[row(1_900)], "rustc 2", "c0ffee").unwrap();
        assert_eq!(rows.findings(AREA, &[row(1_900)]), [""; 0]);
        assert_eq!(rows.compiler(), Some("rustc 2"));
        rows.replace(AREA, &[row(1_400)], "rustc 2", "c0ffee").unwrap();
        assert!(rows.rows[KEY].get("reason").is_none());
    }

    /// Rows that were stored one after the other by one compiler, on the commits 0, 1, ...
    fn history(rows: &[Row]) -> Stored {
        let mut stored = Stored::default();
        for (commit, row) in rows.iter().enumerate() {
            stored.replace(AREA, std::slice::from_ref(row), "rustc 1", &commit.to_string()).unwrap();
        }
        stored
    }

    /// Returns the same row with an accepted value.
    fn accepting(mut stored: Stored, value: u64, reason: &str) -> Stored {
        stored.rows.get_mut(KEY).unwrap()[ACCEPTED] = json!({ "value": value, "reason": reason });
        stored
    }

    /// Given steps of 2 %, each below the tolerance, when they are stored, then the one that leaves the best value by more is found.
    #[test]
    fn steps_within_the_tolerance_are_found_together() {
        assert_eq!(history(&[row(1_020), row(1_000), row(1_020)]).findings(AREA, &[row(1_030)]), [""; 0]);
        let findings = history(&[row(1_020), row(1_000), row(1_020)]).findings(AREA, &[row(1_040)]);
        let expected = "rx.latency is 1040 model_cycles: its best is 1000, of commit 1; improve it, or write `accepted` with value \
                        and reason into its row";
        assert_eq!(findings, [expected]);
    }

    #[test]
    fn storing_a_worse_value_does_not_accept_it() {
        assert_eq!(history(&[row(1_000), row(1_200)]).findings(AREA, &[row(1_200)]).len(), 1);
    }

    #[test]
    fn accepted_value_needs_a_reason() {
        let worse = || history(&[row(1_000), row(1_200)]);
        assert_eq!(accepting(worse(), 1_200, "a feature").findings(AREA, &[row(1_200)]), [""; 0]);
        assert_eq!(accepting(worse(), 1_200, "").findings(AREA, &[row(1_200)]).len(), 1);
        let findings = accepting(worse(), 1_200, "a feature").findings(AREA, &[row(1_240)]);
        assert!(findings[0].contains("of commit 0, 1200 is accepted;"), "{findings:?}");
    }

    #[test]
    fn accepted_value_follows_improvements_alone() {
        let mut rows = accepting(history(&[row(1_000), row(1_200)]), 1_200, "a feature");
        for (value, accepted) in
            [(1_230, Some(1_200.0)), (1_100, Some(1_100.0)), (1_110, Some(1_100.0)), (1_020, None)]
        {
            rows.replace(AREA, &[row(value)], "rustc 1", "7").unwrap();
            assert_eq!(value_of(&rows.rows[KEY], ACCEPTED), accepted, "{value}");
            assert_eq!(value_of(&rows.rows[KEY], BEST), Some(1_000.0));
        }
    }

    #[test]
    fn best_values_of_another_compiler_are_dropped() {
        let mut rows = accepting(history(&[row(1_000), row(1_200)]), 1_200, "a feature");
        rows.replace("irq", &[row(1)], "rustc 2", "7").unwrap();
        assert_eq!([BEST, ACCEPTED].map(|field| rows.rows[KEY].get(field)), [None; 2]);
        assert_eq!(rows.findings(AREA, &[row(1_200)]), [""; 0]);
        rows.replace(AREA, &[row(1_300)], "rustc 2", "8").unwrap();
        assert_eq!(rows.rows[KEY][BEST], json!({ "value": 1_300, "commit": "8" }));
    }

    #[test]
    fn best_of_a_row_of_high_values_is_the_highest() {
        let share = |value: u64| Row::higher("latency", value, "percent");
        let rows = history(&[share(90), share(100), share(98)]);
        assert_eq!(rows.rows[KEY][BEST], json!({ "value": 100, "commit": "1" }));
        assert_eq!(rows.findings(AREA, &[share(97)]), [""; 0]);
        assert_eq!(rows.findings(AREA, &[share(96)]).len(), 1);
    }

    #[test]
    fn rows_of_other_areas_and_noisy_rows_have_no_best() {
        let mut rows = history(&[row(1_000).noisy()]);
        rows.replace("irq", &[row(1_000)], "rustc 1", "0").unwrap();
        assert!(rows.rows.values().all(|row| row.get(BEST).is_none()));
    }

    /// The stored values of the repository pass the check: each accepted value has a reason, and each best value its
    /// commit.
    #[test]
    fn stored_rows_that_are_worse_than_their_best_have_reasons() {
        let stored = Stored::read(&path()).unwrap();
        let ratcheted = stored.rows().filter(|(key, _)| RATCHETED.iter().any(|area| is_of(area, key)));
        for (key, value) in ratcheted {
            assert!(value[BEST]["commit"].is_string(), "{key} has no best value");
            let now = value["value"].as_f64().unwrap();
            let row = if value["better"] == "lower" { Row::lower } else { Row::higher };
            assert_eq!(worse_than_best(key, value, &row(key, now, "")), None);
        }
    }
}
