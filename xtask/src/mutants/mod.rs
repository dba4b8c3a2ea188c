//! `cargo xtask mutants`: deliberate defects in the protocol crate, the applications or the machines of redundancy, of which tests must find most.
//!
//! Defects that no operator of cargo-mutants makes are [patches].

pub mod copy;
mod outcome;
mod patch;
mod patches;
mod sample;
mod selection;
mod tagged;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};
use clap::{Args, value_parser};
use ecss_can_cli::images::support::shard::Shard;
use ecss_can_cli::images::support::{output, project};
use outcome::Outcome;
use sample::Mutant;

use crate::tool::{Source, Tool};

/// Name of the command.
const COMMAND: &str = "mutants";

const MUTANTS: Tool = Tool {
    program: "cargo-mutants",
    version: "27.1.0",
    asked: &["mutants", "--version"],
    subcommand: COMMAND,
    takes: "a minute and a half",
    arguments: &[],
};

/// Configurations in `.cargo`: the tests by clause, and all that may find a mutant of the protocol crate.
const CLAUSES: &str = "mutants";
const ALL: &str = "mutants-all";
/// Mutants of the applications, and their tests in host worlds.
const APPLICATIONS: &str = "mutants-applications";
/// Mutants of the machines of redundancy, and their model with one fault and with two.
const ONE_FAULT: &str = "mutants-redundancy";
const TWO_FAULTS: &str = "mutants-redundancy-two-faults";

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
    #[arg(long, conflicts_with_all = ["applications", "redundancy"])]
    by_clause: bool,

    /// Try mutants of the applications of the images instead of the protocol crate, with their tests in host worlds
    #[arg(long, conflicts_with = "redundancy")]
    applications: bool,

    /// Try mutants of the machines of redundancy, with the model of all their states as the only test
    #[arg(long)]
    redundancy: bool,

    /// Try the defects of these patch files instead, each by the command or the tests that its head names [default: all patches of the project]
    #[arg(long, value_name = "FILE", num_args = 0.., conflicts_with_all = ["sample", "seed", "at_least", "by_clause", "applications", "redundancy"])]
    patch: Option<Vec<PathBuf>>,

    /// Try part I of N of the patches
    #[arg(long, value_name = "I/N", requires = "patch")]
    shard: Option<Shard>,

    /// Print the sample, or the patches, and end
    #[arg(long)]
    list: bool,

    /// Folder for the logs of cargo-mutants, and for the copy of the project that is patched [default: target/mutants] of the project
    #[arg(long, value_name = "DIR", default_value_os_t = project::target("mutants"), hide_default_value = true)]
    out: PathBuf,

    #[command(flatten)]
    source: Source,
}

/// Configurations whose tests meet the mutants: the first one all, each other one those that were missed before it.
type Steps = &'static [&'static str];

impl Options {
    /// The steps, and what found the mutants of the first one, if there are two.
    fn steps(&self) -> (Steps, Option<&'static str>) {
        match self {
            Options { applications: true, .. } => (&[APPLICATIONS], None),
            Options { redundancy: true, .. } => (&[ONE_FAULT, TWO_FAULTS], Some("with one fault")),
            Options { by_clause: true, .. } => (&[CLAUSES], Some("by the tests by clause")),
            _ => (&[CLAUSES, ALL], Some("by the tests by clause")),
        }
    }
}

/// Draws a sample, runs tests against each of its mutants, and prints what they did not find. Or tries patches.
///
/// # Errors
/// When a patch is wrong or its defect is not found, when cargo-mutants is missing or fails, or when tests caught too few.
pub fn run(options: &Options) -> anyhow::Result<()> {
    if let Some(files) = &options.patch {
        let all = patches::read(files)?;
        let total = all.len() as u64;
        if let Some(shard) = options.shard {
            shard.check(COMMAND, total, "patches")?;
        }
        let share = options.shard.map_or(0..total, |shard| shard.share(total));
        let patches = &all[share.start as usize..share.end as usize];
        let tests = patches::Tests::of(patches)?;
        return match options.list {
            true => patches::print(patches, &tests),
            false => patches::run(patches, &tests, &options.out.join("patches")),
        };
    }
    let program = MUTANTS.find(&options.source)?;
    let (steps, finder) = options.steps();
    let list = cargo_mutants(&program, steps[0]).arg("--list").output().with_context(cannot_run)?;
    ensure!(list.status.success(), "cargo mutants --list failed:\n{}", String::from_utf8_lossy(&list.stderr));
    let list = String::from_utf8(list.stdout).context("the list of mutants")?;
    let all: Vec<_> = list.lines().filter_map(Mutant::read).collect();
    let sample = sample::draw(&all, options.sample.into(), options.seed);
    if options.list {
        return sample.iter().try_for_each(|mutant| output::line(mutant.name));
    }
    output::note(format_args!("{} of {} mutants, seed {}", sample.len(), all.len(), options.seed));
    let outcome = try_all(&program, &sample, steps, &options.out)?;
    report(&outcome, sample.len(), finder)?;
    let ((found, viable), at_least) = (outcome.share(), options.at_least);
    ensure!(
        found * 100 >= viable * usize::from(at_least),
        "fewer than {at_least} percent were caught; docs/verification/mutants.md says what to do"
    );
    Ok(())
}

/// Runs the tests of the first step against these mutants, and those of each other step against the missed ones.
fn try_all(program: &Path, sample: &[Mutant<'_>], steps: Steps, out: &Path) -> anyhow::Result<Outcome> {
    let mut outcome = attempt(program, sample, steps[0], out)?;
    for config in &steps[1..] {
        let is_missed = |mutant: &&Mutant<'_>| outcome.missed.iter().any(|name| name == mutant.name);
        let missed: Vec<Mutant<'_>> = sample.iter().filter(is_missed).copied().collect();
        if !missed.is_empty() {
            outcome = outcome.after(attempt(program, &missed, config, out)?);
        }
    }
    Ok(outcome)
}

/// Runs the tests that a configuration names against each mutant.
fn attempt(program: &Path, mutants: &[Mutant<'_>], config: &str, out: &Path) -> anyhow::Result<Outcome> {
    let folder = std::env::current_dir().context("the current folder")?.join(out).join(config);
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let diff = folder.join("sample.diff");
    let text = selection::diff(mutants, |file| {
        fs::read_to_string(project::path(file)).with_context(|| file.to_owned())
    })?;
    fs::write(&diff, text).with_context(|| format!("cannot write {}", diff.display()))?;

    let mut command = cargo_mutants(program, config);
    command.args(["--shuffle", "--output"]).arg(&folder).arg("--in-diff").arg(&diff);
    if config != CLAUSES {
        // cargo-mutants would run the baseline with the tests of the mutated package alone. Without one it guesses no time.
        let seconds = if [ALL, TWO_FAULTS].contains(&config) { "300" } else { "60" };
        command.args(["--baseline", "skip", "--timeout", seconds]);
    }
    command.args(mutants.iter().flat_map(|mutant| ["--re".to_owned(), selection::expression(mutant.name)]));
    let status = command.status().with_context(cannot_run)?;
    // 2: some were missed, 3: a test did not end.
    ensure!(matches!(status.code(), Some(0 | 2 | 3)), "{} failed ({status})", MUTANTS.program);
    Outcome::read(&folder, mutants)
}

fn cargo_mutants(program: &Path, config: &str) -> Command {
    let mut command = Command::new(program);
    ecss_can_cli::images::clean(&mut command).arg("mutants").current_dir(project::path(""));
    command.arg("--config").arg(format!(".cargo/{config}.toml"));
    // The profile decides: only what changed is compiled again.
    command.env_remove("CARGO_INCREMENTAL");
    command
}

fn cannot_run() -> String {
    format!("cannot run {}", MUTANTS.program)
}

/// Prints the missed mutants and the counts.
///
/// # Errors
/// When some of the sample were not tried.
fn report(outcome: &Outcome, sampled: usize, finder: Option<&str>) -> anyhow::Result<()> {
    for name in &outcome.missed {
        output::line(format_args!("missed: {name}"))?;
    }
    let (found, viable) = outcome.share();
    let [endless, unviable] = [&outcome.timeout, &outcome.unviable].map(Vec::len);
    let by_first = finder.map_or(String::new(), |finder| format!(" {} of them {finder},", outcome.by_first));
    output::line(format_args!(
        "{found} of {viable} mutants caught,{by_first} {endless} by a test that did not end; {unviable} more do not compile"
    ))?;
    ensure!(outcome.tried() == sampled, "{} of the sample were not tried", sampled.abs_diff(outcome.tried()));
    Ok(())
}
