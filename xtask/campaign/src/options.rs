//! The command line.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Subcommand, ValueEnum};
use support::misuse::Misuse;

use crate::broken::Rule;

/// Most runs of a campaign.
const MOST_RUNS: u64 = 10_000_000;

/// Command line of `campaign`.
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Exit code 0: no violation; 1: a run violated something; 2: a wrong argument.\n\
        On many machines: one shard on each, then merge. docs/verification/campaign.md shows it with GNU parallel and Slurm."
)]
pub struct Options {
    #[command(subcommand)]
    pub(crate) action: Option<Action>,

    /// Number of runs of the whole campaign [1..10000000]
    #[arg(long, value_name = "N", default_value_t = 1_000, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=MOST_RUNS))]
    pub(crate) runs: u64,

    /// Seed of the scripts
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,

    /// Where the runs fly
    #[arg(long, value_name = "WORLD", value_enum, default_value_t = World::Host)]
    pub(crate) world: World,

    /// Masters in each run: 1, or 2 of which one is the standby [1..2]
    #[arg(long, value_name = "M", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) masters: u8,

    /// Fly one of N shares of the runs only, I from 1 to N
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub(crate) shard: Shard,

    /// Runs at the same time [default: one for each core]
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) jobs: Option<u16>,

    /// Fly the images of the twin as they were built last
    #[arg(long)]
    pub(crate) no_build: bool,

    /// Break a rule on purpose in a world of the host, and fly until a run finds it
    #[arg(long, value_name = "RULE", value_enum, conflicts_with_all = ["world", "masters", "shard", "jobs", "replay"])]
    pub(crate) broken: Option<Rule>,

    /// Folder of the results
    #[arg(long, value_name = "DIR", default_value_os_t = support::project::path("target/campaign"), hide_default_value = true)]
    pub(crate) out: PathBuf,

    /// Fly the script of a file instead, as a violation prints it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["runs", "seed", "masters", "shard"])]
    pub(crate) replay: Option<PathBuf>,
}

/// What else can be done.
#[derive(Subcommand, Debug)]
pub(crate) enum Action {
    /// Join the results of all shards of a campaign and print them
    Merge {
        /// Files that the shards have written
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
}

/// Where runs fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum World {
    /// The nodes' own code on mocks of ports and clocks
    Host,
    /// The images on emulated boards: one master, or two, and two slaves
    Twin,
}

impl World {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            World::Host => "host",
            World::Twin => "twin",
        }
    }
}

/// A share of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from 1.
    pub index: u64,
    /// Of how many.
    pub count: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let numbers = text.split_once('/').map(|(index, count)| (index.parse(), count.parse()));
        match numbers {
            Some((Ok(index), Ok(count))) if 1 <= index && index <= count && count <= MOST_RUNS => {
                Ok(Shard { index, count })
            }
            _ => Err(format!("allowed are I/N with I from 1 to N and N up to {MOST_RUNS}, for example 3/16")),
        }
    }
}

impl Options {
    /// Checks what the parser cannot see.
    pub(crate) fn check(&self) -> Result<(), Misuse> {
        let Shard { count, .. } = self.shard;
        if count > self.runs {
            let runs = self.runs;
            let text = format!(
                "--shard: {count} shards of {runs} runs leave some without any; allowed are 1 to {runs}"
            );
            return Err(Misuse::of("campaign", text));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shard_is_a_number_of_a_count() {
        assert_eq!("3/16".parse(), Ok(Shard { index: 3, count: 16 }));
        for wrong in ["0/4", "5/4", "1", "a/b", "1/0", "-1/4", "1/99999999"] {
            assert!(wrong.parse::<Shard>().is_err_and(|error| error.contains("3/16")), "{wrong}");
        }
    }
}
