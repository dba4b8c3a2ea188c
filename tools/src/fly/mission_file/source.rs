//! Text of a mission file: finds line and key of an error.

use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

use super::schema::File;
use crate::images::support::misuse::Misuse;

/// A mission file and its text.
#[derive(Debug)]
pub struct Source<'a> {
    /// Path of the file, as the user knows it.
    pub path: &'a Path,
    /// Its content.
    pub text: &'a str,
}

impl Source<'_> {
    /// Reads the keys.
    ///
    /// # Errors
    /// When it is no TOML, a key is unknown or missing, or a value has another type.
    pub fn read(&self) -> Result<File, Misuse> {
        toml::from_str(self.text).map_err(|error: Error| {
            let span = error.span().unwrap_or(0..0);
            // A key that is unknown or missing is named by the error itself.
            self.wrong(&span, error.message().replace('\n', "; "))
        })
    }

    /// Returns an error of the value at `span`.
    pub fn wrong(&self, span: &Range<usize>, cause: impl Display) -> Misuse {
        Misuse::of("fly", format!("{}: {cause}", self.origin(span)))
    }

    /// Returns file, line and key of a value, as messages begin with them.
    pub fn origin(&self, span: &Range<usize>) -> String {
        let line = self.text.get(..span.start).unwrap_or_default().matches('\n').count() + 1;
        let key = self.key(span).map_or(String::new(), |key| format!(": {key}"));
        format!("{}:{line}{key}", self.path.display())
    }

    /// Checks the range of a number.
    ///
    /// # Errors
    /// When it is outside.
    pub fn within<T: PartialOrd + Display + Copy>(
        &self,
        value: &Spanned<T>,
        range: &RangeInclusive<T>,
        unit: &str,
    ) -> Result<T, Misuse> {
        let number = *value.get_ref();
        if range.contains(&number) {
            return Ok(number);
        }
        let (start, end) = (range.start(), range.end());
        let cause = format!("{number} is outside of the range; allowed are {start} to {end}{unit}");
        Err(self.wrong(&value.span(), cause))
    }

    /// Returns the dotted key of a place in the file; entries of an array are counted from 0.
    fn key(&self, span: &Range<usize>) -> Option<String> {
        let (table, _) = DeTable::parse_recoverable(self.text);
        in_table(table.get_ref(), span, "")
    }
}

fn in_table(table: &DeTable, span: &Range<usize>, above: &str) -> Option<String> {
    table.iter().find_map(|(name, value)| {
        let key =
            if above.is_empty() { name.get_ref().to_string() } else { format!("{above}.{}", name.get_ref()) };
        in_value(value, span, &key).or_else(|| name.span().contains(&span.start).then_some(key))
    })
}

fn in_value(value: &Spanned<DeValue>, span: &Range<usize>, key: &str) -> Option<String> {
    let deeper = match value.get_ref() {
        DeValue::Table(table) => in_table(table, span, key),
        DeValue::Array(array) => {
            let mut entries = array.iter().enumerate();
            entries.find_map(|(nth, entry)| in_value(entry, span, &format!("{key}[{nth}]")))
        }
        _ => None,
    };
    deeper.or_else(|| value.span().contains(&span.start).then(|| key.to_owned()))
}
