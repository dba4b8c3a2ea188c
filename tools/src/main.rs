//! The program `ecss-can`: see [`ecss_can_cli`]. Exit codes: [`ecss_can_cli::images::support::ending`].

#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use ecss_can_cli::{campaign, completions, doctor, eds, firmware, fly, help, images, man, new, schedule};

/// Run, record and describe a spacecraft with two CAN buses.
#[derive(Parser)]
#[command(name = "ecss-can", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a new slave, master or board into a folder: built, tested and flown at once
    New(new::Options),
    /// Build the images of your project or of this one, and print their paths and sizes
    Build(firmware::build::Options),
    /// Build an image, write it to a board with probe-rs and show its log
    Flash(firmware::flash::Options),
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
    /// Check whether images can be built and boards flashed, and print the commands that install what is missing
    Doctor(doctor::Options),
    /// Print the completions of a shell
    Completions(completions::Options),
    /// Write a man page for each command
    Man(man::Options),
}

/// The command line with examples in its help.
fn command() -> clap::Command {
    help::with_examples(Cli::command())
}

fn main() -> ExitCode {
    let cli = Cli::from_arg_matches(&command().get_matches()).unwrap_or_else(|error| error.exit());
    let outcome = match cli.command {
        Command::New(options) => new::run(&options),
        Command::Build(options) => firmware::build::run(&options),
        Command::Flash(options) => firmware::flash::run(&options),
        Command::Fly(options) => fly::run(&options),
        Command::Twin(options) => fly::live::run(&options),
        Command::Eds(options) => eds::run(&options),
        Command::Campaign(options) => campaign::run(&options),
        Command::Schedule(options) => schedule::run(&options),
        Command::Doctor(options) => doctor::run(&options),
        Command::Completions(options) => completions::run(&options, command()),
        Command::Man(options) => man::run(&options, command()),
    };
    images::support::ending::end(outcome, command())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_example_of_the_help_is_parsed() {
        for (_, examples) in help::EXAMPLES {
            for example in *examples {
                let parsed = command().try_get_matches_from(example.split_whitespace());
                let parsed = parsed.and_then(|matches| Cli::from_arg_matches(&matches));
                assert!(
                    parsed.is_ok(),
                    "{example}: {}",
                    parsed.err().map(|error| error.to_string()).unwrap_or_default()
                );
            }
        }
    }

    #[test]
    fn each_command_has_an_example() {
        for command in command().get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(help.starts_with("Examples:\n    ecss-can "), "{}: {help}", command.get_name());
        }
    }
}
