//! Finds the name of the chip in the manifest and in the description of a board.

use toml::{Table, Value};

use crate::{Chip, Error};

/// The dependency whose feature names the chip.
const HAL: &str = "embassy-stm32";

/// Finds the chip of a board in the text of its `Cargo.toml`: the feature of embassy-stm32 that names one. Reads
/// `[dependencies]` and `[target.*.dependencies]`, also where the dependency is renamed.
///
/// # Errors
/// When it is not TOML, when no chip or several chips are named, or when the chip is not supported.
pub fn chip_of_manifest(manifest: &str) -> Result<Chip, Error> {
    let manifest: Table = parse("Cargo.toml", manifest)?;
    let targets = manifest.get("target").and_then(Value::as_table);
    let of_targets = targets.into_iter().flat_map(|targets| targets.values());
    let tables =
        manifest.get("dependencies").into_iter().chain(of_targets.filter_map(|t| t.get("dependencies")));
    let mut chips: Vec<String> = tables.filter_map(Value::as_table).flat_map(chips_of).collect();
    chips.sort();
    chips.dedup();
    match chips.as_slice() {
        [] => Err(Error::NoChip),
        [chip] => Chip::named(chip),
        _ => Err(Error::SeveralChips { chips }),
    }
}

/// Returns the name of the chip in the text of a `board.toml`, as it stands there: `STM32F446RETx`.
///
/// # Errors
/// When it is not TOML or names no chip.
pub fn chip_of_board(description: &str) -> Result<String, Error> {
    let description: Table = parse("board.toml", description)?;
    let chip = description.get("chip").and_then(Value::as_str);
    chip.map(str::to_owned).ok_or(Error::NoChipOfBoard)
}

fn parse(file: &'static str, text: &str) -> Result<Table, Error> {
    text.parse().map_err(|reason| Error::Toml { file, reason })
}

/// Names of the chips in a table of dependencies.
fn chips_of(dependencies: &Table) -> Vec<String> {
    let hal = dependencies.iter().filter(|(name, dependency)| {
        dependency.get("package").and_then(Value::as_str).unwrap_or(name.as_str()) == HAL
    });
    let features = hal.filter_map(|(_, dependency)| dependency.get("features")?.as_array());
    features
        .flatten()
        .filter_map(Value::as_str)
        .filter(|feature| is_chip(feature))
        .map(str::to_owned)
        .collect()
}

/// Returns whether a feature of embassy-stm32 names a chip. Others have a hyphen there, as `stm32-hrtim`.
fn is_chip(feature: &str) -> bool {
    feature
        .strip_prefix("stm32")
        .is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_alphanumeric()))
}
