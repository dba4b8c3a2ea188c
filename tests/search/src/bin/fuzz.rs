//! Runs a fuzz target for any number of executions.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use search::fuzz::campaign::{self, Campaign, Failure};
use search::fuzz::{Signature, TARGETS, Target};

/// Executions between two reports of progress.
const PORTION: u64 = 10_000;

/// Any sequence of frames: never a panic, never a wrong write, never stuck.
#[derive(Parser)]
struct Arguments {
    /// sdo-server, sdo-client, pdo-mapping, nmt or slave
    #[arg(value_parser = parse_target)]
    target: Target,
    /// How many inputs
    #[arg(long, default_value_t = 10_000_000)]
    executions: u64,
    /// Another seed makes other inputs
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Runs this input alone, and shows where it fails
    #[arg(long)]
    replay: Option<PathBuf>,
}

fn parse_target(name: &str) -> Result<Target, String> {
    let names = TARGETS.map(|target| target.name).join(", ");
    search::fuzz::target(name).ok_or(format!("the targets are {names}"))
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let target = arguments.target;
    if let Some(path) = arguments.replay {
        return match std::fs::read(&path) {
            Ok(input) => match campaign::attempt(target, &input, &mut Signature::default()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(_) => ExitCode::FAILURE,
            },
            Err(error) => {
                eprintln!("{}: {error}", path.display());
                ExitCode::FAILURE
            }
        };
    }
    // A failure is reported once, with its shortest input.
    std::panic::set_hook(Box::new(|_| {}));
    match run(target, arguments.executions, arguments.seed) {
        Ok(steps) => {
            println!(
                "{}: {} executions, seed {}, {steps} steps, no failure",
                target.name, arguments.executions, arguments.seed
            );
            ExitCode::SUCCESS
        }
        Err(failure) => {
            let failure = campaign::shorten(target, failure);
            let path = std::env::temp_dir().join(format!("{}-failed.bin", target.name));
            eprintln!("{}: {}\n{:02X?}", target.name, failure.message, failure.input);
            match std::fs::write(&path, &failure.input) {
                Ok(()) => eprintln!(
                    "again: cargo run --profile fuzz -p search --bin fuzz -- {} --replay {}",
                    target.name,
                    path.display()
                ),
                Err(error) => eprintln!("{}: {error}", path.display()),
            }
            ExitCode::FAILURE
        }
    }
}

fn run(target: Target, executions: u64, seed: u64) -> Result<usize, Failure> {
    let style = "{prefix} {bar:40} {human_pos}/{human_len} {per_sec} {eta} {msg}";
    let style = ProgressStyle::with_template(style).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(executions).with_style(style).with_prefix(target.name);
    let mut campaign = Campaign::new(target, seed);
    campaign.replay()?;
    let mut rest = executions;
    while rest > 0 {
        let portion = rest.min(PORTION);
        campaign.run(portion)?;
        rest -= portion;
        bar.inc(portion);
        bar.set_message(format!("{} steps", campaign.steps()));
    }
    bar.finish_and_clear();
    Ok(campaign.steps())
}
