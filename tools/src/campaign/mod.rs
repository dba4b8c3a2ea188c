//! `cargo campaign`: random faults against the redundancy of a spacecraft.
//!
//! Each run has a [`Script`] from the seed of the campaign and its own number: single faults and pairs of them, at
//! random times, in a spacecraft of one master, or two, and some slaves. Half of the pairs have one cause, such as a
//! jolt of a connector. After each run the same conditions must hold, see [`judge`]. A script with a violation is made
//! as simple as possible and printed; `--replay` runs it.
//!
//! A campaign is divided into shards that run on many machines; equal shards give equal files (see
//! [`crate::images::support::shard`]).

mod application;
mod boards;
pub mod broken;
pub mod failover;
mod flight;
mod host;
pub mod jolt;
pub mod judge;
pub mod kind;
mod nodes;
mod notes;
mod on_twin;
mod options;
pub mod outcome;
pub mod reach;
pub mod results;
pub mod rule;
mod scene;
pub mod script;
mod shrink;
pub mod takeover;
pub mod upsets;

use std::num::NonZero;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;
use std::thread;

use anyhow::bail;
use host::Host;
use on_twin::Twin;
pub use on_twin::prepare as prepare_twin;
use options::Action;
pub use options::{Options, World};
use outcome::Outcome;
use results::{Asked, Results};
use rule::Rule;
use script::Script;

use crate::images::support::misuse::Misuse;
use crate::images::support::output::{self, Silently};
use crate::images::support::project;
use crate::images::support::shard::{self, Part, Run};
use crate::images::support::stop::Stop;

/// Name of the command.
const COMMAND: &str = "campaign";
/// Attempts to find a script with an effective fault; the next one is run in any case.
const MOST_ATTEMPTS: u64 = 9;
/// Number of violations whose scripts are shrunk.
const SHRUNK: usize = 5;

/// Runs a script.
pub fn fly(world: World, script: &Script) -> Outcome {
    match world {
        World::Host => flight::fly(script, || Host::new(script, None)),
        World::Twin | World::Upsets => flight::fly(script, || Twin::new(script)),
    }
}

/// Runs random scripts until a fault of one takes effect or there is a violation. If the campaign selects kinds of
/// faults, there is only one script.
pub fn fly_run(world: World, asked: &Asked, number: u64) -> (Script, Outcome) {
    let run = |attempt| {
        let script = match (&*asked.kinds, world) {
            (&[first], _) => Script::of_kinds(asked.seed, number, first, None),
            (&[first, second, ..], _) => Script::of_kinds(asked.seed, number, first, Some(second)),
            ([], World::Host) => Script::random(asked.seed, number, attempt),
            ([], World::Twin | World::Upsets) => Script::small(asked.seed, number, attempt),
        };
        let script = if asked.masters == 1 { script } else { script.with_standby() };
        let outcome = fly(world, &script);
        (script, outcome)
    };
    if !asked.kinds.is_empty() {
        return run(0);
    }
    let is_done = |outcome: &Outcome| !outcome.violations.is_empty() || outcome.effective.contains(&true);
    let early = (0..MOST_ATTEMPTS).map(run).find(|(_, outcome)| is_done(outcome));
    early.unwrap_or_else(|| run(MOST_ATTEMPTS))
}

/// Executes the command: runs, merges or replays.
///
/// # Errors
/// When a run has a violation, or a file cannot be read or written.
pub fn run(options: &Options) -> anyhow::Result<()> {
    if let Some(Action::Merge { files }) = &options.action {
        if files.first().is_some_and(|first| upsets::is_part(first)) {
            return upsets::merge(files);
        }
        let (run, parts) = shard::merged(COMMAND, files)?;
        return report(&run, &Results::joined(parts));
    }
    if options.world == World::Upsets {
        return upsets::run(&upset_settings(options));
    }
    if options.kinds.len() > 2 || !options.kinds.is_empty() && options.world == World::Twin {
        let text = "--kinds: one or two kinds, in the world host alone";
        return Err(Misuse::of(COMMAND, text.to_owned()).into());
    }
    let prepare = |masters| {
        if options.world == World::Twin {
            on_twin::prepare(masters, !options.no_build)?;
        }
        // A panic of a node is part of the result of its run.
        std::panic::set_hook(Box::new(|_| {}));
        anyhow::Ok(())
    };
    if let Some(path) = &options.replay {
        let refuse = |text: String| Misuse::of(COMMAND, format!("--replay {}: {text}", path.display()));
        let text = std::fs::read(path).map_err(|error| refuse(error.to_string()))?;
        // Comments may have any encoding.
        let script: Script = String::from_utf8_lossy(&text).parse().map_err(refuse)?;
        script.check().map_err(refuse)?;
        prepare(script.masters)?;
        let outcome = fly(options.world, &script);
        outcome.violations.iter().try_for_each(output::line)?;
        return match outcome.violations.len() {
            0 => output::line("no violation"),
            count => bail!("{count} violations"),
        };
    }
    options.shard.check(COMMAND, options.runs, "runs")?;
    if let Some(rule) = options.broken {
        prepare(options.masters)?;
        return find_broken(rule, options);
    }
    let pair = if options.masters == 1 { "" } else { "-pair" };
    let file = options.out.join(options.shard.file(&format!("{}{pair}", options.world.name())));
    shard::prepare(COMMAND, &file)?;
    prepare(options.masters)?;
    let stop = Stop::at_ctrl_c()?;
    let jobs = options.jobs.map_or_else(cores, usize::from);
    let run = Run {
        command: COMMAND.into(),
        commit: shard::commit(),
        shards: options.shard.count,
        parameters: Asked {
            seed: options.seed,
            runs: options.runs,
            world: options.world.name().into(),
            masters: options.masters,
            kinds: options.kinds.clone(),
        },
    };
    // Consecutive runs, so that each shard has all kinds, two faults in half of its runs, and related ones in a
    // quarter.
    let share = options.shard.share(options.runs);
    let mut results = campaign(&run.parameters, options.world, share, jobs, &stop);
    if stop.is_asked() {
        output::warn(format_args!("the campaign was interrupted after {} runs", results.flown));
        return Err(Silently::INTERRUPTED.into());
    }
    // The images of the twin are those of one number of masters.
    let can_fly = |script: &Script| options.world == World::Host || script.masters == options.masters;
    for violation in results.violations.iter_mut().take(SHRUNK) {
        if let Ok(script) = violation.script.parse() {
            let shrunk = shrink::shrink(&script, can_fly, |script| fly(options.world, script));
            violation.shrunk = shrunk.to_string();
        }
    }
    let part = Part { run, shard: options.shard.index, results };
    part.write(&file)?;
    output::note(format_args!("written to {}", project::shown(&file)));
    report(&part.run, &part.results)
}

fn upset_settings(options: &Options) -> upsets::Settings<'_> {
    upsets::Settings {
        seed: options.seed,
        masters: options.masters,
        draws: &options.draws,
        shard: options.shard,
        jobs: options.jobs.map_or_else(cores, usize::from),
        no_build: options.no_build,
        out: &options.out,
        replay: options.replay.as_deref(),
    }
}

/// Runs until a broken rule is detected.
fn find_broken(rule: Rule, options: &Options) -> anyhow::Result<()> {
    let Some((run, script, outcome)) = broken::find(rule, options.seed, options.runs) else {
        bail!("{} runs did not find the broken rule", options.runs);
    };
    let shrunk = shrink::shrink(&script, |_| true, |script| broken::fly(rule, script));
    output::line(format_args!("found by run {run} of seed {}:", options.seed))?;
    outcome.violations.iter().try_for_each(output::line)?;
    output::line("the simplest script that finds it:")?;
    output::line(shrunk.to_string().trim_end())
}

fn report(run: &Run<Asked>, results: &Results) -> anyhow::Result<()> {
    results.lines(run).iter().try_for_each(output::line)?;
    match results.violations.len() {
        0 => Ok(()),
        count => bail!("{count} of {} runs violate something", results.flown),
    }
}

/// Executes a range of the runs on several threads.
pub fn campaign(asked: &Asked, world: World, numbers: Range<u64>, jobs: usize, stop: &Stop) -> Results {
    let mut results = Results::empty();
    let next = AtomicU64::new(numbers.start);
    let template = "{pos} of {len} runs, {msg}, {elapsed}, {eta} left";
    let bar = output::progress(numbers.end - numbers.start, template);
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..jobs {
            let (sender, end, next) = (sender.clone(), numbers.end, &next);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= end {
                        return;
                    }
                    let (script, outcome) = fly_run(world, asked, number);
                    if stop.is_asked() || sender.send((number, script, outcome)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (number, script, outcome) in receiver {
            results.add(number, &script, outcome);
            bar.inc(1);
            bar.set_message(format!("{} violations", results.violations.len()));
        }
    });
    bar.finish_and_clear();
    results.sort();
    results
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, NonZero::get)
}
