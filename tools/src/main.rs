//! The program `ecss-can`: see [`ecss_can_cli`]. Exit codes: [`ecss_can_cli::images::support::ending`].

#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use ecss_can_cli::{campaign, eds, fly, images, schedule};

/// Run, record and describe a spacecraft with two CAN buses.
#[derive(Parser)]
#[command(name = "ecss-can", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run the real firmware on emulated boards, cut the nominal bus, and write a report of the fail-over
    Fly(Box<fly::CommandLine>),
    /// Run the spacecraft in real time and offer both buses as SLCAN over TCP, until Ctrl-C
    Twin(fly::live::Options),
    /// Write EDS and DCF of a device from its dictionary, or check the DCF of a network
    Eds(eds::Options),
    /// Run thousands of spacecraft with random faults, and check what must hold after each
    Campaign(campaign::Options),
    /// Compute a bound of the response time of each frame of the mission
    Schedule(schedule::Options),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Fly(options) => fly::run(&options),
        Command::Twin(options) => fly::live::run(&options),
        Command::Eds(options) => eds::run(&options),
        Command::Campaign(options) => campaign::run(&options),
        Command::Schedule(options) => schedule::run(&options),
    };
    images::support::ending::end(outcome, Cli::command())
}
