//! Manifests that are read, changed and written.

use std::fs;
use std::path::Path;

use toml::{Table, Value};

use crate::images::Error;

/// Returns the text of a file.
///
/// # Errors
/// When it cannot be read.
pub(in crate::images) fn text(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|error| Error::Directory(path.to_owned(), error))
}

/// Reads a manifest.
///
/// # Errors
/// When it cannot be read, or is not TOML.
pub(in crate::images) fn parse(path: &Path) -> Result<Table, Error> {
    parse_text(&text(path)?, path)
}

/// Parses the text of a manifest; errors name `path`.
///
/// # Errors
/// When it is not TOML.
pub(in crate::images) fn parse_text(text: &str, path: &Path) -> Result<Table, Error> {
    text.parse().map_err(|error| Error::Manifest(path.to_owned(), format!("{error}")))
}

/// The table `key` of a table, made where it is missing.
pub(in crate::images) fn table<'a>(of: &'a mut Table, key: &str) -> &'a mut Table {
    let value = of.entry(key).or_insert_with(|| Table::new().into());
    if !value.is_table() {
        *value = Table::new().into();
    }
    value.as_table_mut().expect("a table")
}

/// Returns an array of texts.
pub(in crate::images) fn strings<T: Into<String>>(texts: impl IntoIterator<Item = T>) -> Value {
    texts.into_iter().map(|text| Value::from(text.into())).collect::<Vec<_>>().into()
}

/// Writes a file unless it has this content, because cargo rebuilds after a change.
///
/// # Errors
/// When it cannot be written.
pub(in crate::images) fn store(path: &Path, content: &str) -> Result<(), Error> {
    if fs::read_to_string(path).is_ok_and(|there| there == content) {
        return Ok(());
    }
    let unusable = |error| Error::Directory(path.to_owned(), error);
    path.parent().map_or(Ok(()), fs::create_dir_all).map_err(unusable)?;
    fs::write(path, content).map_err(unusable)
}
