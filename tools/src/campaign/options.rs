//! The command line.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::campaign::kind::Kind;
use crate::campaign::rule::Rule;
use crate::campaign::upsets::Draws;
use crate::images::support::shard::Shard;

/// Greatest number of runs of a campaign.
const MOST_RUNS: u64 = 10_000_000;

/// Command line of `campaign`.
#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Exit code 0: no violation; 1: a run violated something, or files to merge are not all parts of one run; \
        2: a wrong argument.\n\
        On many machines: one shard on each, then merge. docs/verification/campaign.md shows it with GNU parallel and Slurm."
)]
pub struct Options {
    #[command(subcommand)]
    pub(in crate::campaign) action: Option<Action>,

    /// Number of runs of the whole campaign [1..10000000]
    #[arg(long, value_name = "N", default_value_t = 1_000, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=MOST_RUNS))]
    pub(in crate::campaign) runs: u64,

    /// Seed of the scripts
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(in crate::campaign) seed: u64,

    /// Where the scripts run
    #[arg(long, value_name = "WORLD", value_enum, default_value_t = World::Host)]
    pub(in crate::campaign) world: World,

    /// Masters in each run: 1, or 2 of which one is the standby [1..2]
    #[arg(long, value_name = "M", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(in crate::campaign) masters: u8,

    /// Draw faults of this kind only, or one of each of these two kinds in each run (world host)
    #[arg(long, value_name = "KIND[,KIND]", value_delimiter = ',', value_enum, conflicts_with_all = ["broken", "replay"])]
    pub(in crate::campaign) kinds: Vec<Kind>,

    /// Numbers of upsets of each place, for example ram=3000,flash=60 (world upsets, in the place of --runs)
    #[arg(long, value_name = "PLACE=N", value_delimiter = ',', conflicts_with_all = ["broken", "replay", "kinds"])]
    pub(in crate::campaign) draws: Vec<Draws>,

    /// Run one of N parts, I from 1 to N, and write its results to DIR/WORLD-I-of-N.json
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub(in crate::campaign) shard: Shard,

    /// Runs at the same time [default: one for each core]
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(in crate::campaign) jobs: Option<u16>,

    /// Run the images on the twin as they were built last
    #[arg(long)]
    pub(in crate::campaign) no_build: bool,

    /// Break a rule on purpose in a world of the host, and run scripts until one finds it
    #[arg(long, value_name = "RULE", value_enum, conflicts_with_all = ["world", "masters", "shard", "jobs", "replay"])]
    pub(in crate::campaign) broken: Option<Rule>,

    /// Folder of the results
    #[arg(long, value_name = "DIR", default_value_os_t = crate::images::support::project::target("campaign"), hide_default_value = true)]
    pub(in crate::campaign) out: PathBuf,

    /// Run the script of a file instead, as a violation prints it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["runs", "seed", "masters", "shard"])]
    pub(in crate::campaign) replay: Option<PathBuf>,
}

/// Other actions of the command.
#[derive(Subcommand, Debug)]
pub(in crate::campaign) enum Action {
    /// Join the results of all shards of a campaign and print them
    Merge {
        /// Files that the shards have written
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
    },
}

/// Place in which scripts run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum World {
    /// The nodes' own code on mocks of ports and clocks
    Host,
    /// The images on emulated boards: one master, or two, and two slaves
    Twin,
    /// The images on emulated boards, one bit of which is inverted
    Upsets,
}

impl World {
    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            World::Host => "host",
            World::Twin => "twin",
            World::Upsets => "upsets",
        }
    }
}
