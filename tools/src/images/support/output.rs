//! Output to terminals and pipes, and exit codes for a closed pipe.
//!
//! `println!` panics when its pipe is closed (`cargo demo | head`). Commands print by [`line()`], which returns an
//! error instead, or by [`note`], which continues.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

use anyhow::Context;
use console::style;
use indicatif::{ProgressBar, ProgressStyle};

/// Ends a command early without a message, with this exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("ended with exit code {0}")]
pub struct Silently(pub u8);

impl Silently {
    /// The reader of stdout has left: 128 + SIGPIPE, as a shell reports it of other commands.
    pub const PIPE_CLOSED: Silently = Silently(141);
    /// Ctrl-C or SIGTERM: 128 + SIGINT.
    pub const INTERRUPTED: Silently = Silently(130);
}

/// Prints a line on stdout.
///
/// # Errors
/// [`Silently::PIPE_CLOSED`] when its reader has left; otherwise the error of writing, a full disk for example.
pub fn line(line: impl Display) -> anyhow::Result<()> {
    text(format_args!("{line}\n"))
}

/// Prints on stdout without a line end.
///
/// # Errors
/// As [`line()`].
pub fn text(text: impl Display) -> anyhow::Result<()> {
    let mut stdout = io::stdout().lock();
    match write!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Err(Silently::PIPE_CLOSED.into()),
        outcome => outcome.context("cannot write to stdout"),
    }
}

/// Prints a line on stderr. A closed pipe is ignored.
pub fn note(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints a warning by [`note`].
pub fn warn(line: impl Display) {
    note(format_args!("{} {line}", style("warning:").yellow().bold().for_stderr()));
}

/// Prints an error by [`note`].
pub fn complain(line: impl Display) {
    note(format_args!("{} {line}", style("error:").red().bold().for_stderr()));
}

/// Shows a progress bar on a terminal, nothing elsewhere. `template`: format of `indicatif` after a bar of 40 cells.
pub fn progress(length: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let style = ProgressStyle::with_template(&format!("{{bar:40.cyan/blue}} {template}"));
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
