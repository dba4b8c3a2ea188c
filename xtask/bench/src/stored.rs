//! Figures that the repository keeps in `xtask/bench/stored.json`, so that a change of one of them is seen.
//!
//! The file has rows as `summary.json` has them. A row that does not hold its target has a `reason` beside it, which people write.
//! [`Stored::findings`] compares a run with it, and `page` makes the tables of the documentation of it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde_json::{Value, json};

use super::row::Row;
use firmware_images::support::project;

/// Largest difference from the stored value that is not reported, as a share of it.
const TOLERANCE: f64 = 0.03;

/// The row that names the compiler of the images.
const TOOLCHAIN: &str = "toolchain";

/// The stored rows, by area and name: `rx.interrupt_to_dictionary`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stored {
    rows: BTreeMap<String, Value>,
}

/// Where the file is.
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

    /// The compiler of the images that were measured.
    pub fn compiler(&self) -> Option<&str> {
        self.rows.get(TOOLCHAIN)?.get("value")?.as_str()
    }

    /// All rows by their names, that of the compiler included.
    pub fn rows(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.rows.iter().map(|(name, row)| (name.as_str(), row))
    }

    /// Replaces the rows of an area. The reason of a row stays as long as its target does not hold.
    ///
    /// # Errors
    /// When a row is no JSON.
    pub fn replace(&mut self, area: &str, rows: &[Row], compiler: &str) -> anyhow::Result<()> {
        let before = self.rows.clone();
        self.rows.retain(|key, _| !is_of(area, key));
        for row in rows {
            let key = format!("{area}.{}", row.name);
            let mut value = serde_json::to_value(row)?;
            if let Some(reason) = before.get(&key).and_then(|stored| stored.get("reason"))
                && row.holds() == Some(false)
            {
                value["reason"] = reason.clone();
            }
            self.rows.insert(key, value);
        }
        self.rows.insert(TOOLCHAIN.into(), json!({ "value": compiler, "unit": "compiler of the images" }));
        Ok(())
    }

    /// Compares the rows of an area with the stored ones. Returns a sentence for each difference that counts.
    pub fn findings(&self, area: &str, rows: &[Row]) -> Vec<String> {
        let key = |row: &Row| format!("{area}.{}", row.name);
        let mut findings: Vec<String> = rows.iter().filter_map(|row| self.finding(&key(row), row)).collect();
        let measured: Vec<String> = rows.iter().map(key).collect();
        let missing = self.rows.keys().filter(|key| is_of(area, key) && !measured.contains(key));
        findings.extend(missing.map(|key| format!("{key} is stored but was not measured")));
        findings
    }

    fn finding(&self, key: &str, row: &Row) -> Option<String> {
        let Row { value, unit, .. } = row;
        let Some(stored) = self.rows.get(key) else {
            return Some(format!("{key} is not stored"));
        };
        let (now, before) = (value.as_f64()?, stored.get("value")?.as_f64()?);
        let target = row.target.as_ref().map(ToString::to_string).unwrap_or_default();
        if row.holds() == Some(false) {
            if stored.get("holds").and_then(Value::as_bool) == Some(true) {
                return Some(format!("{key} is {value} {unit}: its target {target} held before"));
            }
            if stored.get("reason").and_then(Value::as_str).is_none_or(str::is_empty) {
                return Some(format!(
                    "{key} is {value} {unit}: its target {target} does not hold, without a reason"
                ));
            }
        }
        let differs = !row.noisy && (now - before).abs() > TOLERANCE * before.abs();
        differs.then(|| format!("{key} is {value} {unit}: {before} is stored"))
    }
}

fn is_of(area: &str, key: &str) -> bool {
    key.split_once('.').is_some_and(|(of, _)| of == area)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: &str = "rx";

    fn row(value: u64) -> Row {
        Row::lower("latency", value, "model_cycles").within(1_500)
    }

    fn stored(row: Row) -> Stored {
        let mut stored = Stored::default();
        stored.replace(AREA, &[row], "rustc 1").unwrap();
        stored
    }

    fn with_reason(row: Row) -> Stored {
        let mut stored = stored(row);
        stored.rows.get_mut("rx.latency").unwrap()["reason"] = "the heartbeat comes first".into();
        stored
    }

    #[test]
    fn equal_rows_have_no_finding() {
        assert_eq!(stored(row(1_000)).findings(AREA, &[row(1_000)]), [""; 0]);
        assert_eq!(stored(row(1_000)).findings(AREA, &[row(1_030)]), [""; 0], "3 % are allowed");
        assert_eq!(with_reason(row(2_000)).findings(AREA, &[row(2_000)]), [""; 0]);
    }

    #[test]
    fn value_that_differs_is_found() {
        for value in [969, 1_031] {
            let expected = format!("rx.latency is {value} model_cycles: 1000 is stored");
            assert_eq!(stored(row(1_000)).findings(AREA, &[row(value)]), [expected]);
        }
    }

    #[test]
    fn target_that_held_before_is_found() {
        let findings = stored(row(1_490)).findings(AREA, &[row(1_501)]);
        assert_eq!(findings, ["rx.latency is 1501 model_cycles: its target 1500 held before"]);
    }

    #[test]
    fn target_without_a_reason_is_found() {
        let findings = stored(row(2_000)).findings(AREA, &[row(2_000)]);
        let expected = "rx.latency is 2000 model_cycles: its target 1500 does not hold, without a reason";
        assert_eq!(findings, [expected]);
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
        rows.replace(AREA, &[row(1_900)], "rustc 2").unwrap();
        assert_eq!(rows.findings(AREA, &[row(1_900)]), [""; 0]);
        assert_eq!(rows.compiler(), Some("rustc 2"));
        rows.replace(AREA, &[row(1_400)], "rustc 2").unwrap();
        assert!(rows.rows["rx.latency"].get("reason").is_none());
    }

    #[test]
    fn noisy_row_may_differ_but_holds_its_target() {
        let stored = stored(row(1_000).noisy());
        assert_eq!(stored.findings(AREA, &[row(1_500).noisy()]), [""; 0]);
        let findings = stored.findings(AREA, &[row(1_501).noisy()]);
        assert_eq!(findings, ["rx.latency is 1501 model_cycles: its target 1500 held before"]);
    }
}
