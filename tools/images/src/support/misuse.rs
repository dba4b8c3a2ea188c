//! A wrong command line that only becomes clear after parsing.

use std::fmt::Display;

use clap::error::ErrorKind;

/// What was wrong, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct Misuse {
    command: &'static str,
    text: String,
}

impl Misuse {
    /// Of an option of the subcommand `command`.
    pub fn of(command: &'static str, text: impl Into<String>) -> Self {
        Misuse { command, text: text.into() }
    }

    /// Of the value of an option; `cause` has what is wrong with it, and what is allowed.
    pub fn value(command: &'static str, option: &str, value: impl Display, cause: impl Display) -> Self {
        Misuse::of(command, format!("invalid value '{value}' for '{option}': {cause}"))
    }

    /// Reports it as clap reports what it finds itself, and ends the program with exit code 2. `cli` is the command line
    /// of the whole program.
    pub(crate) fn exit(&self, mut cli: clap::Command) -> ! {
        cli.build();
        let command = cli.find_subcommand_mut(self.command).expect("a subcommand reports its own misuse");
        command.error(ErrorKind::ValueValidation, &self.text).exit()
    }
}
