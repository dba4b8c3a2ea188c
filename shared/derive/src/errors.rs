//! Errors of a declaration, collected so that the compiler shows all of them at once.

use proc_macro2::{Span, TokenStream};
use syn::{Error, Result};

/// Errors found so far.
#[derive(Default)]
pub struct Errors(Option<Error>);

impl Errors {
    /// Adds one error.
    pub fn add(&mut self, error: Error) {
        match &mut self.0 {
            Some(errors) => errors.combine(error),
            none => *none = Some(error),
        }
    }

    /// Adds an error that the compiler finds by itself: it has no text, and [`Errors::texts`] leaves it out.
    pub fn add_silent(&mut self) {
        self.add(Error::new(Span::call_site(), ""));
    }

    /// Returns the errors for the compiler.
    pub fn texts(errors: Error) -> TokenStream {
        let all = errors.into_iter().filter(|error| !error.to_string().is_empty());
        all.map(Error::into_compile_error).collect()
    }

    /// Adds the error of a result, or gives its value.
    pub fn take<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|error| self.add(error)).ok()
    }

    /// Adds an error for each number that occurs again, at the place where it does.
    pub fn add_repeated(&mut self, mut numbers: Vec<(u16, Span)>, message: impl Fn(u16) -> String) {
        // Stable: the first one stays first.
        numbers.sort_by_key(|(number, _)| *number);
        for pair in numbers.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            self.add(Error::new(pair[1].1, message(pair[1].0)));
        }
    }

    /// Returns all errors as one.
    ///
    /// # Errors
    /// If there is at least one error.
    pub fn finish(self) -> Result<()> {
        self.0.map_or(Ok(()), Err)
    }
}
