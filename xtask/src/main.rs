//! `cargo xtask`: benchmarks and checks of this repository. The program `ecss-can` has the commands for users.
//!
//! Exit codes: [`ecss_can_cli::images::support::ending`].

#![forbid(unsafe_code)]

mod api;
mod bench;
mod clippy;
mod compliance;
mod licences;
mod mutants;
mod pictures;
mod release;
mod selftest;
mod test_all;
mod tool;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

/// Measure and check this repository. To build, flash and run a spacecraft: cargo ecss-can --help
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Check a bare board: flash a self-test and show its results, or run it on the emulated board
    Selftest(selftest::Options),
    /// Measure latency, load, fail-over, clocks and sizes, for target/bench/summary.json
    Bench(bench::Options),
    /// Measure flash and static RAM of the images of every board, for target/bench/summary.json
    Sizes(bench::SizesOptions),
    /// Draw the pictures of the documentation from simulations and runs of the images: docs/*.svg
    Pictures,
    /// Trace requirements of the standard to tests: docs/compliance.md
    Compliance(compliance::Options),
    /// List the public items of both protocol crates by module: docs/api.md
    Api(api::Options),
    /// Check licences, versions and sources of all packages with cargo-deny
    Licences(tool::Source),
    /// Change the protocol crate in many places, one by one, and count the changes that its tests find
    Mutants(mutants::Options),
    /// Check the published packages as a new user has them; write release notes and bills of materials
    Release(release::Options),
    /// Run all tests: those of `cargo test`, all other runs of images, all commands, and those with tools of others
    TestAll(test_all::Options),
    /// Lint firmware and boards for their target; warnings are errors
    Clippy(ecss_can_cli::images::support::board::Target),
    /// Check that embassy-stm32 has a chip of each STM32F4 line, that chip support compiles for one of each family, and slaves on its CAN drivers
    Chips,
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Selftest(options) => selftest::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Sizes(options) => bench::sizes(&options),
        Command::Pictures => pictures::run(),
        Command::Compliance(options) => compliance::run(&options),
        Command::Api(options) => api::run(&options),
        Command::Licences(options) => licences::run(&options),
        Command::Mutants(options) => mutants::run(&options),
        Command::Release(options) => release::run(&options),
        Command::TestAll(options) => test_all::run(&options),
        Command::Clippy(options) => clippy::run(&options),
        Command::Chips => ecss_can_cli::images::check_chips().map_err(Into::into),
    };
    ecss_can_cli::images::support::ending::end(outcome, Cli::command())
}
