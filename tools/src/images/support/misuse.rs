//! A wrong command line that is detected only after parsing.

use std::fmt::Display;

use clap::error::ErrorKind;

/// The error, and the allowed values.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct Misuse {
    command: &'static str,
    text: String,
}

impl Misuse {
    /// Makes an error of an option of the subcommand `command`.
    pub fn of(command: &'static str, text: impl Into<String>) -> Self {
        Misuse { command, text: text.into() }
    }

    /// Makes an error of the value of an option; `cause` contains the error and the allowed values.
    pub fn value(command: &'static str, option: &str, value: impl Display, cause: impl Display) -> Self {
        Misuse::of(command, format!("invalid value '{value}' for '{option}': {cause}"))
    }

    /// Reports it in the format of clap, and ends the program with exit code 2. `cli` is the command line of the whole
    /// program.
    pub(in crate::images) fn exit(&self, mut cli: clap::Command) -> ! {
        cli.build();
        let command = cli.find_subcommand_mut(self.command).expect("a subcommand reports its own misuse");
        command.error(ErrorKind::ValueValidation, &self.text).exit()
    }
}
