//! `cargo campaign --world upsets`: one flipped bit in a board, and what the spacecraft makes of it.
//!
//! An *upset* inverts one bit of one board of a spacecraft in flight: of RAM, a core register, a register of a peripheral, the program or
//! the parameter store. The images run on emulated boards ([`world`]). A flight is copied at an instant between 5 and 6 s, the bit is
//! inverted, and 12 to 13 s are compared with the flight without upset. Then a *probe* cuts the active bus, and with two masters takes
//! the power of the active one, because a defect may wait for a change of the bus. [`outcome`] defines the results.
//!
//! RAM is pruned by its uses: the reference records for each instant which bytes the core reads before it writes them. An upset in any
//! other byte cannot change the flight, and is not flown.
//!
//! Limits: one bit in one board; upsets of the buffers behind registers (prescaler, pipeline, protocol engine of CAN) are not drawn.

pub mod choice;
pub mod fly;
mod grid;
pub mod outcome;
pub mod place;
mod places;
pub mod record;
pub mod results;
pub mod world;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;
use std::thread;

use anyhow::bail;
use choice::{Draw, choose};
use outcome::Outcome;
use place::{Place, Upset};
use results::{Asked, Results};
use world::World;

use crate::images::support::misuse::Misuse;
use crate::images::support::output::{self, Silently};
use crate::images::support::project;
use crate::images::support::shard::{self, Part, Run, Shard};
use crate::images::support::stop::Stop;

/// Name of the command in its parts.
const COMMAND: &str = "campaign upsets";
/// Greatest number of draws of a place.
const MOST_DRAWS: u64 = 1_000_000;
/// Draws without `--draws`.
const DRAWS: [(Place, u64); 6] = [
    (Place::Ram, 3_000),
    (Place::Core, 150),
    (Place::Masks, 15),
    (Place::Peripherals, 300),
    (Place::Flash, 60),
    (Place::Store, 30),
];

/// A place with its number of draws, as `--draws` has it: `ram=3000`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws(Place, u64);

impl std::str::FromStr for Draws {
    type Err = String;

    fn from_str(text: &str) -> Result<Draws, String> {
        let allowed = || {
            let places = Place::ALL.map(Place::name).join(", ");
            format!("allowed are PLACE=N with N from 0 to {MOST_DRAWS} and the places {places}")
        };
        let (place, count) = text.split_once('=').ok_or_else(allowed)?;
        let place = Place::ALL.into_iter().find(|other| other.name() == place).ok_or_else(allowed)?;
        let count = count.parse().ok().filter(|count| *count <= MOST_DRAWS).ok_or_else(allowed)?;
        Ok(Draws(place, count))
    }
}

/// Options of a campaign of upsets.
pub(in crate::campaign) struct Settings<'a> {
    /// Seed of the instants and places.
    pub seed: u64,
    /// Number of masters: 1 or 2.
    pub masters: u8,
    /// Number of draws by place. Empty: as many as are usual.
    pub draws: &'a [Draws],
    /// Part of the draws.
    pub shard: Shard,
    /// Number of threads.
    pub jobs: usize,
    /// Uses the images that were built last.
    pub no_build: bool,
    /// Folder of the results.
    pub out: &'a Path,
    /// File of an upset that is flown instead.
    pub replay: Option<&'a Path>,
}

/// Returns whether a file is a part of a campaign of upsets.
pub(in crate::campaign) fn is_part(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let part: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    part.is_some_and(|part| part["run"]["command"] == COMMAND)
}

/// Joins the parts of all shards, and prints the results.
///
/// # Errors
/// When a file cannot be read, a shard is missing, or an upset has a bad outcome.
pub(in crate::campaign) fn merge(files: &[PathBuf]) -> anyhow::Result<()> {
    let (run, parts) = shard::merged(COMMAND, files)?;
    report(&run, &Results::joined(parts))
}

/// Executes the command: draws and flies upsets, or replays one.
///
/// # Errors
/// When an upset has a bad outcome, or a file cannot be read or written.
pub(in crate::campaign) fn run(options: &Settings) -> anyhow::Result<()> {
    if let Some(path) = options.replay {
        let refuse = |text: String| Misuse::of("campaign", format!("--replay {}: {text}", path.display()));
        let text = std::fs::read_to_string(path).map_err(|error| refuse(error.to_string()))?;
        return replay(&text.parse().map_err(refuse)?, options);
    }
    let drawn = if options.draws.is_empty() {
        BTreeMap::from(DRAWS)
    } else {
        options.draws.iter().map(|Draws(place, count)| (*place, *count)).collect()
    };
    let asked = Asked { seed: options.seed, masters: options.masters, draws: drawn };
    options.shard.check("campaign", asked.total(), "draws")?;
    let pair = if options.masters == 1 { "" } else { "-pair" };
    let file = options.out.join(options.shard.file(&format!("upsets{pair}")));
    shard::prepare("campaign", &file)?;
    let world = World::prepare(options.masters, options.seed, options.no_build)?;
    // A panic of the emulator is part of the result of its draw.
    std::panic::set_hook(Box::new(|_| {}));
    let stop = Stop::at_ctrl_c()?;
    let share = options.shard.share(asked.total());
    let results = campaign(&world, &asked, share, options.jobs, &stop);
    if stop.is_asked() {
        output::warn("the campaign was interrupted");
        return Err(Silently::INTERRUPTED.into());
    }
    let run = Run {
        command: COMMAND.into(),
        commit: shard::commit(),
        shards: options.shard.count,
        parameters: asked,
    };
    let part = Part { run, shard: options.shard.index, results };
    part.write(&file)?;
    output::note(format_args!("written to {}", project::shown(&file)));
    report(&part.run, &part.results)
}

fn replay(upset: &Upset, options: &Settings) -> anyhow::Result<()> {
    let world = World::prepare(upset.masters, options.seed, options.no_build)?;
    std::panic::set_hook(Box::new(|_| {}));
    let flown = fly::fly(&world, upset);
    output::line(format_args!("{}: {}", flown.outcome.name(), flown.name))?;
    flown.reasons.iter().try_for_each(|reason| output::line(format_args!("  {reason}")))?;
    if flown.outcome.is_bad() { bail!("the outcome is bad") } else { Ok(()) }
}

fn report(run: &Run<Asked>, results: &Results) -> anyhow::Result<()> {
    results.lines(run).iter().try_for_each(output::line)?;
    match results.bad() {
        0 => Ok(()),
        count => bail!("{count} upsets have a bad outcome"),
    }
}

/// Draws and flies a range of the upsets on several threads.
pub fn campaign(world: &World, asked: &Asked, numbers: Range<u64>, jobs: usize, stop: &Stop) -> Results {
    let mut results = Results::default();
    let next = AtomicU64::new(numbers.start);
    let bar =
        output::progress(numbers.end - numbers.start, "{pos} of {len} upsets, {msg}, {elapsed}, {eta} left");
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..jobs {
            let (sender, end, next) = (sender.clone(), numbers.end, &next);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let place = asked.place(number).filter(|_| number < end && !stop.is_asked());
                    let Some((place, within)) = place else { return };
                    let draw = choose(world, asked.seed, place, within);
                    let flown = draw.filter(|draw| !draw.is_unused).map(|draw| fly::fly(world, &draw.upset));
                    if sender.send((number, place, draw, flown)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (number, place, draw, flown) in receiver {
            match (draw, flown) {
                (Some(Draw { upset, .. }), Some(flown)) => results.add(number, &upset, flown),
                _ => results.count(place, Outcome::NotUsed),
            }
            bar.inc(1);
            bar.set_message(format!("{} bad", results.bad()));
        }
    });
    bar.finish_and_clear();
    results.sort();
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_places_with_numbers() {
        assert_eq!("ram=30".parse(), Ok(Draws(Place::Ram, 30)));
        for wrong in ["ram", "ram=", "ram=-1", "moon=3", "ram=1000001"] {
            assert!(wrong.parse::<Draws>().is_err_and(|error| error.contains("peripherals")), "{wrong}");
        }
    }
}
