//! `summary.json`: rows of all areas, from this run and from earlier ones.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

use anyhow::Context;
use serde_json::{Value, json};

use super::row::Row;

/// The row that names the compiler of the images.
const TOOLCHAIN: &str = "toolchain";

/// One flat object: `"area.name": {...}`, and a row `toolchain`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    rows: BTreeMap<String, Value>,
}

impl Summary {
    /// The summary at `path`; an empty one when there is none.
    ///
    /// # Errors
    /// When there is something else at `path`.
    pub fn read(path: &Path) -> anyhow::Result<Summary> {
        if !path.exists() {
            return Ok(Summary::default());
        }
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let rows = serde_json::from_str(&text)
            .with_context(|| format!("{} is not a JSON object of rows; remove it", path.display()))?;
        Ok(Summary { rows })
    }

    /// Replaces all rows of an area; the others stay as they are.
    ///
    /// # Errors
    /// When a row is no JSON.
    pub fn replace(&mut self, area: &str, rows: &[Row]) -> anyhow::Result<()> {
        self.rows.retain(|key, _| key.split_once('.').is_none_or(|(of, _)| of != area));
        for row in rows {
            self.rows.insert(format!("{area}.{}", row.name), serde_json::to_value(row)?);
        }
        Ok(())
    }

    /// Names the compiler; returns the one that was named before, when it was another.
    pub fn set_toolchain(&mut self, compiler: &str) -> Option<String> {
        let row = json!({ "value": compiler, "unit": "compiler of the images" });
        let before = self.rows.insert(TOOLCHAIN.into(), row)?;
        before["value"].as_str().filter(|before| *before != compiler).map(String::from)
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// When the directory or the file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let failure = || format!("cannot write {}", path.display());
        let part = path.with_extension("part");
        fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).with_context(failure)?;
        fs::write(&part, format!("{self}\n")).with_context(failure)?;
        fs::rename(&part, path).with_context(failure)
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&serde_json::to_string_pretty(&self.rows).map_err(|_| fmt::Error)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_other_areas_stay() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("bench/summary.json");
        let mut summary = Summary::read(&path).unwrap();
        summary.replace("size", &[Row::lower("slave.flash", 30_000, "bytes")]).unwrap();
        summary.replace("rx", &[Row::lower("old", 1, "model_cycles")]).unwrap();
        summary.write(&path).unwrap();

        let mut summary = Summary::read(&path).unwrap();
        summary.replace("rx", &[Row::lower("new", 2, "model_cycles")]).unwrap();
        summary.write(&path).unwrap();

        let json: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        assert_eq!(json["size.slave.flash"]["value"], 30_000);
        assert_eq!(json["rx.new"]["value"], 2);
        assert!(json.get("rx.old").is_none());
    }

    #[test]
    fn another_compiler_is_noticed() {
        let mut summary = Summary::default();
        assert_eq!(summary.set_toolchain("rustc 1"), None);
        assert_eq!(summary.set_toolchain("rustc 1"), None);
        assert_eq!(summary.set_toolchain("rustc 2"), Some("rustc 1".into()));
    }

    #[test]
    fn a_file_that_is_no_summary_is_not_overwritten() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("summary.json");
        fs::write(&path, "[1, 2]").unwrap();
        let error = format!("{:#}", Summary::read(&path).unwrap_err());
        assert!(error.contains("summary.json") && error.contains("remove it"), "{error}");
    }
}
