//! The end of a command: its exit code, and the message of a failure.
//!
//! | exit code | meaning |
//! | --- | --- |
//! | 0 | the command succeeded |
//! | 1 | something failed; the reason is on stderr |
//! | 2 | the command line was wrong |
//! | 130 | Ctrl-C or SIGTERM ended it |
//! | 141 | the reader of its output has left |

use std::process::ExitCode;

use crate::images::support::misuse::Misuse;
use crate::images::support::output::{Silently, complain};

/// Reports a failure that has not been reported yet, and returns the exit code. `cli` is the command line of the whole
/// program: it reports [`Misuse`] of a subcommand with the usage of that subcommand.
pub fn end(outcome: anyhow::Result<()>, cli: clap::Command) -> ExitCode {
    let Err(failure) = outcome else { return ExitCode::SUCCESS };
    if let Some(&Silently(code)) = failure.downcast_ref() {
        return ExitCode::from(code);
    }
    if let Some(misuse) = failure.downcast_ref::<Misuse>() {
        misuse.exit(cli);
    }
    complain(format_args!("{failure:#}"));
    ExitCode::FAILURE
}
