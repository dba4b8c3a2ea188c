//! `cargo xtask mutants`: deliberate defects in the protocol crate, the applications or the machines of redundancy, of which tests must find most.
//!
//! A sample is cut into shards, so that it runs on many machines (see [`firmware_images::support::shard`]). Defects that no operator of cargo-mutants makes
//! are [patches].

mod copy;
mod outcome;
mod patch;
mod patches;
mod sample;
mod selection;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};
use clap::{Args, Subcommand, value_parser};
use serde::{Deserialize, Serialize};

use crate::tool::{Source, Tool};
use firmware_images::support::shard::{self, Part, Run, Shard};
use firmware_images::support::{output, project};
use outcome::Outcome;
use sample::Mutant;

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
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "On many machines: one shard on each, then `cargo xtask mutants merge FILE...`; docs/verification/campaign.md shows how."
)]
pub struct Options {
    #[command(subcommand)]
    action: Option<Action>,

    /// How many mutants to try, drawn at random
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = value_parser!(u16).range(1..))]
    sample: u16,

    /// Where random numbers begin: the same mutants for the same seed
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,

    #[command(flatten)]
    bar: Bar,

    /// Run the tests by clause alone: what they miss counts as missed
    #[arg(long, conflicts_with_all = ["applications", "redundancy"])]
    by_clause: bool,

    /// Try mutants of the applications of the images instead of the protocol crate, with their tests in host worlds
    #[arg(long, conflicts_with = "redundancy")]
    applications: bool,

    /// Try mutants of the machines of redundancy, with the model of all their states as the only test
    #[arg(long)]
    redundancy: bool,

    /// Try the defects of these patch files instead, each by the command in its head [default: all patches of the project]
    #[arg(long, value_name = "FILE", num_args = 0.., conflicts_with_all = ["sample", "seed", "at_least", "by_clause", "applications", "redundancy", "shard"])]
    patch: Option<Vec<PathBuf>>,

    /// Print the sample, or the patches, and end
    #[arg(long)]
    list: bool,

    /// Try one of N parts of the sample, I from 1 to N, and write its results to DIR/part-I-of-N.json
    #[arg(long, value_name = "I/N", conflicts_with = "at_least")]
    shard: Option<Shard>,

    /// Folder for the logs of cargo-mutants, and for the copy of the project that is patched [default: target/mutants] of the project
    #[arg(long, value_name = "DIR", default_value_os_t = project::target("mutants"), hide_default_value = true)]
    out: PathBuf,

    #[command(flatten)]
    source: Source,
}

/// What else can be done.
#[derive(Subcommand, Debug)]
enum Action {
    /// Join the results of all shards of a sample, then print and judge them as one run does
    Merge {
        /// Files that the shards have written
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,

        #[command(flatten)]
        bar: Bar,
    },
}

/// What tests must find.
#[derive(Args, Clone, Copy, Debug)]
struct Bar {
    /// Least share of mutants that tests must catch, in percent
    #[arg(long, value_name = "PERCENT", default_value_t = 85, value_parser = value_parser!(u8).range(0..=100))]
    at_least: u8,
}

/// What decides the outcome, beside the commit.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Parameters {
    seed: u64,
    /// Number of mutants of the sample.
    sample: usize,
    /// Number of mutants of which the sample is drawn.
    mutants: usize,
    by_clause: bool,
    subject: Subject,
}

/// Code that has the mutants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Subject {
    Protocol,
    Applications,
    Redundancy,
}

impl Subject {
    /// What found the mutants of the first step, if there are two.
    const fn first_finder(self) -> Option<&'static str> {
        match self {
            Subject::Protocol => Some("by the tests by clause"),
            Subject::Applications => None,
            Subject::Redundancy => Some("with one fault"),
        }
    }
}

impl Options {
    fn subject(&self) -> Subject {
        match self {
            Options { applications: true, .. } => Subject::Applications,
            Options { redundancy: true, .. } => Subject::Redundancy,
            _ => Subject::Protocol,
        }
    }

    /// Configurations whose tests meet the mutants: the first one all, each other one those that were missed before it.
    fn steps(&self) -> &'static [&'static str] {
        match self.subject() {
            Subject::Applications => &[APPLICATIONS],
            Subject::Redundancy => &[ONE_FAULT, TWO_FAULTS],
            Subject::Protocol if self.by_clause => &[CLAUSES],
            Subject::Protocol => &[CLAUSES, ALL],
        }
    }
}

/// Draws a sample, runs tests against each of its mutants, and prints what they did not find. Or joins the results of
/// shards of a sample, or tries patches.
///
/// # Errors
/// When a patch is wrong or its defect is not found, when cargo-mutants is missing or fails, when tests caught too few, or when the files to join are not all parts of one run.
pub fn run(options: &Options) -> anyhow::Result<()> {
    if let Some(Action::Merge { files, bar }) = &options.action {
        let (run, parts): (Run<Parameters>, Vec<Outcome>) = shard::merged(COMMAND, files)?;
        let outcome = parts.into_iter().fold(Outcome::default(), Outcome::and);
        report(&outcome, run.parameters.sample, run.parameters.subject)?;
        return judge(&outcome, *bar);
    }
    if let Some(files) = &options.patch {
        let patches = patches::read(files)?;
        return match options.list {
            true => patches::print(&patches),
            false => patches::run(&patches, &options.out.join("patches")),
        };
    }
    let program = MUTANTS.find(&options.source)?;
    let list = cargo_mutants(&program, options.steps()[0]).arg("--list").output().with_context(cannot_run)?;
    ensure!(list.status.success(), "cargo mutants --list failed:\n{}", String::from_utf8_lossy(&list.stderr));
    let list = String::from_utf8(list.stdout).context("the list of mutants")?;
    let all: Vec<_> = list.lines().filter_map(Mutant::read).collect();
    let sample = sample::draw(&all, options.sample.into(), options.seed);
    let parameters = Parameters {
        seed: options.seed,
        sample: sample.len(),
        mutants: all.len(),
        by_clause: options.by_clause,
        subject: options.subject(),
    };
    let Some(shard) = options.shard else {
        if options.list {
            return print(&sample);
        }
        output::note(format_args!("{} of {} mutants, seed {}", sample.len(), all.len(), options.seed));
        let outcome = try_all(&program, &sample, options, &options.out)?;
        report(&outcome, sample.len(), options.subject())?;
        return judge(&outcome, options.bar);
    };
    let total = sample.len() as u64;
    shard.check(COMMAND, total, "mutants")?;
    let share = shard.share(total);
    let sample = &sample[share.start as usize..share.end as usize];
    if options.list {
        return print(sample);
    }
    let file = options.out.join(shard.file("part"));
    shard::prepare(COMMAND, &file)?;
    let run = Run { command: COMMAND.into(), commit: shard::commit(), shards: shard.count, parameters };
    let count = share.end - share.start;
    output::note(format_args!("{count} of {total} mutants, shard {shard}, seed {}", options.seed));
    // Shards on one machine have logs of their own.
    let results = try_all(&program, sample, options, &file.with_extension(""))?;
    report(&results, sample.len(), options.subject())?;
    Part { run, shard: shard.index, results }.write(&file)?;
    output::note(format_args!("results of shard {shard} written to {}", project::shown(&file)));
    Ok(())
}

fn print(sample: &[Mutant<'_>]) -> anyhow::Result<()> {
    sample.iter().try_for_each(|mutant| output::line(mutant.name))
}

/// Runs the tests of the first step against these mutants, and those of each other step against the missed ones. The logs go to `out`.
fn try_all(program: &Path, sample: &[Mutant<'_>], options: &Options, out: &Path) -> anyhow::Result<Outcome> {
    let (first, others) = options.steps().split_first().context("a step")?;
    let mut outcome = attempt(program, sample, first, out)?;
    for config in others {
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
    firmware_images::clean(&mut command).arg("mutants").current_dir(project::path(""));
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
fn report(outcome: &Outcome, sampled: usize, subject: Subject) -> anyhow::Result<()> {
    for name in &outcome.missed {
        output::line(format_args!("missed: {name}"))?;
    }
    let (found, viable) = outcome.share();
    let [endless, unviable] = [&outcome.timeout, &outcome.unviable].map(Vec::len);
    let finder = subject.first_finder();
    let by_first = finder.map_or(String::new(), |finder| format!(" {} of them {finder},", outcome.by_first));
    output::line(format_args!(
        "{found} of {viable} mutants caught,{by_first} {endless} by a test that did not end; {unviable} more do not compile"
    ))?;
    ensure!(outcome.tried() == sampled, "{} of the sample were not tried", sampled.abs_diff(outcome.tried()));
    Ok(())
}

/// Compares with the share that is asked for.
///
/// # Errors
/// When it is not reached.
fn judge(outcome: &Outcome, Bar { at_least }: Bar) -> anyhow::Result<()> {
    let (found, viable) = outcome.share();
    ensure!(
        found * 100 >= viable * usize::from(at_least),
        "fewer than {at_least} percent were caught; docs/mutants.md says what to do"
    );
    Ok(())
}
