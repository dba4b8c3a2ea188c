//! `cargo xtask mutants`: deliberate defects in the protocol crate, of which its tests must find most.

mod outcome;
mod sample;
mod selection;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};
use clap::{Args, value_parser};

use crate::tool::{Source, Tool};
use outcome::Outcome;
use sample::Mutant;
use support::{output, project};

const MUTANTS: Tool = Tool {
    program: "cargo-mutants",
    version: "27.1.0",
    asked: &["mutants", "--version"],
    subcommand: "mutants",
    takes: "a minute and a half",
    arguments: &[],
};

/// Configurations in `.cargo`: the tests by clause, and all that may find a mutant.
const CLAUSES: &str = "mutants";
const ALL: &str = "mutants-all";

/// Command line of `mutants`.
#[derive(Args, Debug)]
pub struct Options {
    /// How many mutants to try, drawn at random
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = value_parser!(u16).range(1..))]
    sample: u16,

    /// Where random numbers begin: the same mutants for the same seed
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,

    /// Least share of mutants that tests must catch, in percent
    #[arg(long, value_name = "PERCENT", default_value_t = 85, value_parser = value_parser!(u8).range(0..=100))]
    at_least: u8,

    /// Run the tests by clause alone: what they miss counts as missed
    #[arg(long)]
    by_clause: bool,

    /// Print the sample and end
    #[arg(long)]
    list: bool,

    /// Folder for the logs of cargo-mutants [default: target/mutants] of the project
    #[arg(long, value_name = "DIR", default_value_os_t = project::path("target/mutants"), hide_default_value = true)]
    out: PathBuf,

    #[command(flatten)]
    source: Source,
}

/// Draws a sample, runs the tests by clause against each of its mutants, and prints what they did not find.
///
/// # Errors
/// When cargo-mutants is missing or fails, or when tests caught too few.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let program = MUTANTS.find(&options.source)?;
    let list = cargo_mutants(&program, CLAUSES).arg("--list").output().with_context(cannot_run)?;
    ensure!(list.status.success(), "cargo mutants --list failed:\n{}", String::from_utf8_lossy(&list.stderr));
    let list = String::from_utf8(list.stdout).context("the list of mutants")?;
    let all: Vec<_> = list.lines().filter_map(Mutant::read).collect();
    let sample = sample::draw(&all, options.sample.into(), options.seed);
    if options.list {
        return sample.iter().try_for_each(|mutant| output::line(mutant.name));
    }
    output::note(format_args!("{} of {} mutants, seed {}", sample.len(), all.len(), options.seed));

    let outcome = attempt(&program, &sample, CLAUSES, &options.out)?;
    let outcome = match outcome.missed.clone() {
        missed if missed.is_empty() || options.by_clause => outcome,
        missed => outcome.after(attempt(&program, &missed, ALL, &options.out)?),
    };
    report(&outcome, sample.len(), options.at_least)
}

/// Runs the tests that a configuration names against each mutant.
fn attempt<'a>(
    program: &Path,
    mutants: &[Mutant<'a>],
    config: &str,
    out: &Path,
) -> anyhow::Result<Outcome<'a>> {
    let folder = std::env::current_dir().context("the current folder")?.join(out).join(config);
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let diff = folder.join("sample.diff");
    let text = selection::diff(mutants, |file| {
        fs::read_to_string(project::path(file)).with_context(|| file.to_owned())
    })?;
    fs::write(&diff, text).with_context(|| format!("cannot write {}", diff.display()))?;

    let mut command = cargo_mutants(program, config);
    command.args(["--shuffle", "--output"]).arg(&folder).arg("--in-diff").arg(&diff);
    if config == ALL {
        // cargo-mutants would run the baseline with the tests of the mutated package alone. Without one it guesses no time.
        command.args(["--baseline", "skip", "--timeout", "300"]);
    }
    command.args(mutants.iter().flat_map(|mutant| ["--re".to_owned(), selection::expression(mutant.name)]));
    let status = command.status().with_context(cannot_run)?;
    // 2: some were missed, 3: a test did not end.
    ensure!(matches!(status.code(), Some(0 | 2 | 3)), "{} failed ({status})", MUTANTS.program);
    Outcome::read(&folder, mutants)
}

fn cargo_mutants(program: &Path, config: &str) -> Command {
    let mut command = Command::new(program);
    firmware_images::clean(&mut command).arg("mutants").current_dir(project::path(""));
    command.arg("--config").arg(format!(".cargo/{config}.toml"));
    // The profile decides: only what changed is compiled again.
    command.env_remove("CARGO_INCREMENTAL");
    command
}

fn cannot_run() -> String {
    format!("cannot run {}", MUTANTS.program)
}

/// Counts, and compares with the share that is asked for.
fn report(outcome: &Outcome<'_>, sampled: usize, at_least: u8) -> anyhow::Result<()> {
    for mutant in &outcome.missed {
        output::line(format_args!("missed: {}", mutant.name))?;
    }
    let (found, viable) = outcome.share();
    let [endless, unviable] = [&outcome.timeout, &outcome.unviable].map(Vec::len);
    output::line(format_args!(
        "{found} of {viable} mutants caught, {endless} of them by a test that did not end; {unviable} more do not compile"
    ))?;
    ensure!(outcome.tried() == sampled, "{} of the sample were not tried", sampled - outcome.tried());
    ensure!(
        found * 100 >= viable * usize::from(at_least),
        "fewer than {at_least} percent were caught; docs/mutants.md says what to do"
    );
    Ok(())
}
