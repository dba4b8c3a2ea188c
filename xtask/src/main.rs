//! `cargo demo`, `cargo twin`, `cargo master`, `cargo slave` and `cargo xtask`: what people run at the root of this repository.
//!
//! Exit codes: 0 all went well, 1 something failed (the reason is on stderr), 2 the command line was wrong, 130 it was
//! interrupted, 141 the reader of its output has left.

#![forbid(unsafe_code)]

mod eds;
mod firmware;
mod flash;
mod licences;
mod mutants;
mod pictures;
mod selftest;
mod test_tools;
mod tool;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use support::misuse::Misuse;
use support::output::{self, Silently};

/// Build, fly and inspect the dual-bus spacecraft.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Fly the real firmware on emulated boards: cut the nominal bus, watch the fail-over
    Demo(demo::Options),
    /// Run the spacecraft in real time and offer both buses as SLCAN over TCP, until Ctrl-C
    Twin(live::Options),
    /// Build the firmware images and print where they are and how big
    Firmware(firmware::Options),
    /// Build an image, write it to a board with probe-rs and show its log
    Flash(flash::Options),
    /// Check a bare board: flash a self-test and show what it finds, or fly it on the emulated board
    Selftest(selftest::Options),
    /// Measure: latency, load, fail-over, cost of the demo, sizes; write target/bench/summary.json
    Bench(bench::Options),
    /// Measure flash and static RAM of the images of every board; add them to target/bench/summary.json
    Sizes(bench::SizesOptions),
    /// Bound the response time of every frame of the mission: a network on paper
    Schedule(schedule::Options),
    /// Fly thousands of spacecraft with random faults, and check what must hold after each
    Campaign(campaign::Options),
    /// Draw the pictures of the documentation anew, from simulations and flights: docs/*.svg
    Pictures,
    /// Write EDS and DCF of the devices from their dictionaries: docs/eds
    Eds(eds::Options),
    /// Trace requirements of the standard to tests: docs/compliance.md
    Compliance(compliance::Options),
    /// Check licences, versions and sources of all packages with cargo-deny
    Licences(tool::Source),
    /// Change the protocol crate on purpose, in many places one by one: its tests must find it
    Mutants(mutants::Options),
    /// Test flights, recordings, reports and data sheets with tools of others: python-can, canopen, tshark, chromium ...
    TestTools(test_tools::Options),
    /// Lint firmware and boards for their target; warnings are errors
    Clippy(support::board::Target),
    /// Check that chip support compiles for a chip of each STM32F4 line
    Chips,
}

/// Reports a failure that has not been reported yet.
fn end(failure: &anyhow::Error) -> ExitCode {
    if let Some(&Silently(code)) = failure.downcast_ref() {
        return ExitCode::from(code);
    }
    if let Some(misuse) = failure.downcast_ref::<Misuse>() {
        misuse.exit(Cli::command());
    }
    output::complain(format_args!("{failure:#}"));
    ExitCode::FAILURE
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Demo(options) => demo::run(&options),
        Command::Twin(options) => live::run(&options),
        Command::Firmware(options) => firmware::run(&options),
        Command::Flash(options) => flash::run(&options),
        Command::Selftest(options) => selftest::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Sizes(options) => bench::sizes(&options),
        Command::Schedule(options) => schedule::run(&options),
        Command::Campaign(options) => campaign::run(&options),
        Command::Pictures => pictures::run(),
        Command::Eds(options) => eds::run(&options),
        Command::Compliance(options) => compliance::run(&options),
        Command::Licences(options) => licences::run(&options),
        Command::Mutants(options) => mutants::run(&options),
        Command::TestTools(options) => test_tools::run(&options),
        Command::Clippy(options) => firmware::clippy(&options),
        Command::Chips => firmware_images::check_chips().map_err(Into::into),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => end(&failure),
    }
}
