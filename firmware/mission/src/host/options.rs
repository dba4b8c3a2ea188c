//! Options of the programs.

use clap::{CommandFactory, FromArgMatches, Parser};
use ecss_can::types::{Duration, Instant};

const LONGEST: u32 = 86_400;

const EXIT_CODES: &str = "Exit codes: 0 end of the run, 1 something failed, 2 wrong command line, 130 Ctrl-C, 141 the reader of \
    stdout has left.\nTo flash a board: cargo slave, cargo minimal, cargo master. The images on emulated boards: cargo demo.";

/// Options of a run.
#[derive(Clone, Debug, PartialEq, Eq, Parser)]
#[command(version, after_help = EXIT_CODES)]
pub struct Options {
    /// Length of the run in virtual seconds; 0: until Ctrl-C [0..86400]
    #[arg(long, value_name = "N", default_value_t = 10, allow_negative_numbers = true, value_parser = seconds)]
    pub seconds: u32,

    /// Virtual second at which the nominal bus is cut; a shorter run has no cut [0..86400]
    #[arg(long, value_name = "N", default_value_t = 4, allow_negative_numbers = true, value_parser = seconds)]
    pub cut_at: u32,

    /// Print every frame in the format of candump. Default: heartbeats, SYNC, commands and telemetry, each at most once
    /// a second
    #[arg(long)]
    pub frames: bool,

    /// Run in real time. Default: as fast as this computer can
    #[arg(long)]
    pub real_time: bool,
}

impl Options {
    /// Reads the command line. An invalid one, `--help` and `--version` end the program.
    pub fn parse(about: &'static str) -> Options {
        let matches = Options::command().about(about).get_matches();
        Options::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }

    /// Returns the end of the run.
    pub fn end(&self) -> Instant {
        if self.seconds == 0 { Instant::NEVER } else { second(self.seconds) }
    }

    /// Returns the instant of the cut.
    pub fn cut(&self) -> Instant {
        second(self.cut_at)
    }
}

fn second(number: u32) -> Instant {
    Instant::ZERO + Duration::from_millis(1_000).times(number)
}

fn seconds(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(seconds @ 0..=LONGEST) => Ok(seconds),
        _ => Err(format!("allowed are whole seconds from 0 to {LONGEST}")),
    }
}
