//! Errors of a declaration, collected so that the compiler shows all of them at once.

use proc_macro2::Span;
use syn::{Error, Result};

/// Errors found so far.
#[derive(Default)]
pub struct Errors(Option<Error>);

impl Errors {
    /// Adds one.
    pub fn add(&mut self, error: Error) {
        match &mut self.0 {
            Some(errors) => errors.combine(error),
            none => *none = Some(error),
        }
    }

    /// Adds the error of a result, or gives its value.
    pub fn take<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|error| self.add(error)).ok()
    }

    /// Adds an error for each number that stands a second time, at its place.
    pub fn add_repeated(&mut self, mut numbers: Vec<(u16, Span)>, message: impl Fn(u16) -> String) {
        // Stable: the first one stays first.
        numbers.sort_by_key(|(number, _)| *number);
        for pair in numbers.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            self.add(Error::new(pair[1].1, message(pair[1].0)));
        }
    }

    /// All of them as one error.
    ///
    /// # Errors
    /// When there are any.
    pub fn finish(self) -> Result<()> {
        self.0.map_or(Ok(()), Err)
    }
}
