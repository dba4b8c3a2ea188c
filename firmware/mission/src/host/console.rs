//! Output of a program: a line for each event, with its virtual time.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use ecss_can::types::Instant;
use indicatif::{ProgressBar, ProgressStyle};
use log::{LevelFilter, Log, Metadata, Record};

/// The reader of stdout has left: 128 + SIGPIPE.
const PIPE_CLOSED: u8 = 141;
/// Path of the applications in the log. Behind it is the module of the application, named after its node.
const APPLICATIONS: &str = "mission::application::";

/// Prints lines with the virtual time, and shows the progress of the run if stderr is a terminal. Clones are the same
/// console.
#[derive(Clone, Debug)]
pub struct Console(Arc<Screen>);

#[derive(Debug)]
struct Screen {
    /// Virtual time, microseconds.
    time: AtomicU64,
    progress: ProgressBar,
    /// First line that could not be printed.
    failure: OnceLock<io::Error>,
}

impl Console {
    /// Makes the console of a run of `seconds`; zero: without end. From now on it prints the messages of applications.
    pub(super) fn start(seconds: u32) -> Console {
        let screen =
            Screen { time: AtomicU64::new(0), progress: progress(seconds), failure: OnceLock::new() };
        let console = Console(Arc::new(screen));
        // Fails if another logger was set before; that one receives the messages.
        if log::set_logger(Box::leak(Box::new(console.clone()))).is_ok() {
            log::set_max_level(LevelFilter::Info);
        }
        console
    }

    /// Prints an event of `source`: a node, a bus or a part of a board.
    pub fn line(&self, source: &str, text: impl Display) {
        let us = self.time().as_micros();
        self.raw(format_args!("{:>5}.{:06}  {source:<10}  {text}", us / 1_000_000, us % 1_000_000));
    }

    /// Prints a line without time and source.
    pub(super) fn raw(&self, line: impl Display) {
        let printed = self.0.progress.suspend(|| writeln!(io::stdout().lock(), "{line}"));
        if let Err(error) = printed {
            // The first failure ends the run; later ones are consequences.
            let _ = self.0.failure.set(error);
        }
    }

    /// Returns the virtual time.
    pub fn time(&self) -> Instant {
        Instant::from_micros(self.0.time.load(Ordering::Relaxed))
    }

    pub(super) fn set_time(&self, now: Instant) {
        self.0.time.store(now.as_micros(), Ordering::Relaxed);
        self.0.progress.set_position(now.as_micros() / 1_000);
    }

    /// Returns the exit code after a line that could not be printed.
    pub(super) fn failure(&self) -> Option<ExitCode> {
        let error = self.0.failure.get()?;
        if error.kind() == ErrorKind::BrokenPipe {
            return Some(ExitCode::from(PIPE_CLOSED));
        }
        eprintln!("error: cannot write to stdout: {error}");
        Some(ExitCode::FAILURE)
    }

    pub(super) fn finish(&self) {
        self.0.progress.finish_and_clear();
    }
}

impl Log for Console {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= LevelFilter::Info
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let target = record.target();
            let of_application = target.strip_prefix(APPLICATIONS).unwrap_or(target);
            let node = of_application.split("::").next().unwrap_or_default();
            self.line(node, format_args!("{:<5} {}", record.level(), record.args()));
        }
    }

    fn flush(&self) {}
}

/// Makes a progress bar, or a spinner for a run without end; visible only on a terminal.
fn progress(seconds: u32) -> ProgressBar {
    let (bar, template) = match seconds {
        0 => (ProgressBar::new_spinner(), "{spinner} {pos} ms of virtual time, {elapsed} on this computer"),
        _ => (
            ProgressBar::new(u64::from(seconds) * 1_000),
            "{bar:40.cyan/blue} {pos} of {len} ms of virtual time, {elapsed} on this computer",
        ),
    };
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
