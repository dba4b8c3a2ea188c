//! Finds the name of the chip in the manifest and in the description of a board.

use toml_edit::{DocumentMut, Item, TableLike, Value};

use crate::{Chip, Error};

/// The dependency whose feature names the chip.
const HAL: &str = "embassy-stm32";

/// Finds the chip of a board in the text of its `Cargo.toml`: the feature of embassy-stm32 that names one. Reads
/// `[dependencies]` and `[target.*.dependencies]`, also where the dependency is renamed.
///
/// # Errors
/// When it is not TOML, when no chip or several chips are named, or when the chip is not supported.
pub fn chip_of_manifest(manifest: &str) -> Result<Chip, Error> {
    let manifest = parse("Cargo.toml", manifest)?;
    let targets = manifest.get("target").and_then(Item::as_table_like);
    let of_targets = targets.into_iter().flat_map(|targets| targets.iter());
    let tables = manifest
        .get("dependencies")
        .into_iter()
        .chain(of_targets.filter_map(|(_, target)| target.as_table_like()?.get("dependencies")));
    let mut chips: Vec<String> = tables.filter_map(Item::as_table_like).flat_map(chips_of).collect();
    chips.sort();
    chips.dedup();
    match chips.as_slice() {
        [] => Err(Error::NoChip),
        [chip] => Chip::named(chip),
        _ => Err(Error::SeveralChips { chips }),
    }
}

/// Returns the name of the chip in the text of a `board.toml`, unchanged, for example `STM32F446RETx`.
///
/// # Errors
/// When it is not TOML or names no chip.
pub fn chip_of_board(description: &str) -> Result<String, Error> {
    let description = parse("board.toml", description)?;
    let chip = description.get("chip").and_then(Item::as_str);
    chip.map(str::to_owned).ok_or(Error::NoChipOfBoard)
}

fn parse(file: &'static str, text: &str) -> Result<DocumentMut, Error> {
    text.parse().map_err(|reason| Error::Toml { file, reason })
}

/// Names of the chips in a table of dependencies.
fn chips_of(dependencies: &dyn TableLike) -> Vec<String> {
    let tables = dependencies.iter().filter_map(|(name, item)| Some((name, item.as_table_like()?)));
    let hal = tables
        .filter(|(name, dependency)| dependency.get("package").and_then(Item::as_str).unwrap_or(name) == HAL);
    let features = hal.filter_map(|(_, dependency)| dependency.get("features")?.as_array());
    features
        .flatten()
        .filter_map(Value::as_str)
        .filter(|feature| is_chip(feature))
        .map(str::to_owned)
        .collect()
}

/// Returns whether a feature of embassy-stm32 names a chip. Other features have a hyphen at that place, as
/// `stm32-hrtim`.
fn is_chip(feature: &str) -> bool {
    feature
        .strip_prefix("stm32")
        .is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_alphanumeric()))
}
