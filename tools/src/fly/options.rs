//! The command line of the demo: defaults, ranges and error messages.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Range, RangeInclusive};
use std::path::PathBuf;
use std::str::FromStr;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, FromArgMatches};

use super::criterion::Criterion;
use super::fault::TimedCommand;
use super::own::Build;
use super::setup::{NodeNumber, Setup, crystal_ppm, place_m};
use crate::images::support::fleet::{Fleet, Images, NodeFile, node_and_file};
use crate::images::support::misuse::Misuse;
use crate::images::support::node::{FIRST, LAST, MASTER, Node};
use crate::images::support::project;

/// Allowed lengths of a run, virtual seconds.
pub const SECONDS: RangeInclusive<f64> = 1.0..=3600.0;

/// Seed of a run without `--seed`.
pub const SEED: u64 = 1;

/// Node-ID of a package that is a slave: behind those of the shipped slaves.
const OWN_SLAVE: Node = 5;

/// Run one master and some slaves on two CAN buses, cause faults, and report.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Every run with the same options gives byte-identical logs: all times are virtual.\n\
    In a folder with a package of firmware this command builds its image and data sheet, and runs them with shipped boards:\n\
    a slave as node 5, in profile standard. A mission file describes all of it: docs/mission-file.md.\n\
    Examples: ecss-can fly; ecss-can fly flight.toml; ecss-can fly --place 5=12.5 --fault \"5 power 5 off\" --fault \"6 power 5 on\"\n\
    With an image of your own the flight is judged and reported by what the standards define: NMT\n\
    states, heartbeats, changes of bus, bus load. Commands and telemetry of the shipped mission are left out. With --eds the\n\
    report has the last values of its PDOs.\n\
    Exit code 0: all slaves were operational at the end, no frame was lost, no board locked up or panicked;\n\
    1: one of these failed, the reason is printed; 2: wrong command line; 130: stopped by Ctrl-C or SIGTERM, what was\n\
    flown is written all the same; 141: the reader of its output has left, likewise.")]
pub struct Options {
    /// Mission file (TOML): boards, images, places, faults with times, criteria. Other options of this command replace its entries
    /// [default: mission.toml beside the Cargo.toml of the project, if there is one]
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,

    /// Package of yours that is built and run [default: that of the current folder, outside of the repository of ecss-can]
    #[arg(long, value_name = "NAME")]
    pub package: Option<String>,

    /// Cargo.toml of the project [default: the next one from the current folder upwards]
    #[arg(long, value_name = "FILE")]
    pub manifest_path: Option<PathBuf>,

    /// Node-ID of the package, if it is a slave [2..15]
    #[arg(long, value_name = "N", default_value_t = OWN_SLAVE, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(i64::from(FIRST)..=i64::from(LAST)))]
    pub node: Node,

    /// Place of node N [1..15] on both buses, metres from the master's end [0..1000]; may be given several times. Without it the seed
    /// chooses 1 to 30 m for a slave, and the first master is at 0 m
    #[arg(long = "place", value_name = "N=METRES", value_parser = place_m)]
    pub places: Vec<NodeNumber>,

    /// Error of the crystal of node N [1..15] at the start, parts per million [-200..200]; may be given several times. Without it the
    /// seed chooses -50 to 50
    #[arg(long = "crystal", value_name = "N=PPM", value_parser = crystal_ppm)]
    pub crystals: Vec<NodeNumber>,

    /// Fault, or the end of one: a second of the run, and a command of `ecss-can twin`, as in "5 cut nominal 0.5" or
    /// "8 reset 3"; may be given several times. Without --cut-at there are no other faults
    #[arg(long = "fault", value_name = "S COMMAND")]
    pub faults: Vec<TimedCommand>,

    /// Boards and images.
    #[command(flatten)]
    pub fleet: Fleet,

    /// Number of shipped minimal slaves (ECSS clause 9), beside the others: the nodes behind theirs, up to 15 (in profile
    /// librecube node 6 uses selective bus access) [0..13]
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(0..=13))]
    pub minimal: u8,

    /// How many of the minimal slaves, the last ones, have one CAN controller and two transceivers (ECSS Figure A-6), and so
    /// selective bus access; up to the value of --minimal [0..13]
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(0..=13))]
    pub one_controller: u8,

    /// Length of the run in virtual seconds, long enough for what follows the cut [1..3600]
    #[arg(long, value_name = "S", default_value_t = 40.0, allow_negative_numbers = true, value_parser = seconds)]
    pub seconds: f64,

    /// When the nominal bus is cut next to the master, in virtual seconds [0..SECONDS], or "never"
    /// [default: half of SECONDS], never with other faults; node 4 needs 13 s after the cut to be found again, and up to
    /// 38.8 s after a cut in the first 0.6 s, before the master has heard a slave; a shorter run is refused.
    /// In profile standby: when the active master loses its power, at least 5. The standby is reset at a quarter of it, and the
    /// nominal bus is cut between the two halves of the slaves at half of it. "never" leaves out all three faults
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub cut_at: Option<CutAt>,

    /// Chooses crystal errors, places on the bus and power-on times [0..18446744073709551615]
    #[arg(long, value_name = "N", default_value_t = SEED, allow_negative_numbers = true)]
    pub seed: u64,

    /// EDS or DCF of node N [1..15], by which the report shows the last values of its PDOs under the names of its objects; may be
    /// given several times. The shipped images have theirs in docs/eds
    #[arg(long = "eds", value_name = "N=FILE", value_parser = own_sheet)]
    pub sheets: Vec<NodeFile>,

    /// Directory for logs, pcapng, report and summary, as seen from the current one; created when missing. The files of an
    /// earlier run there are removed first [default: target/fly] of the project
    #[arg(long, value_name = "DIR", default_value_os_t = project::target("fly"), hide_default_value = true)]
    pub out: PathBuf,

    /// Places, crystals and power-on times of a mission file.
    #[arg(skip)]
    pub setups: BTreeMap<Node, Setup>,

    /// Criteria of a mission file.
    #[arg(skip)]
    pub criteria: Vec<Criterion>,

    /// Packages that are built before the flight.
    #[arg(skip)]
    pub builds: Vec<Build>,
}

/// The options as given, and which of them were: those replace the entries of a mission file.
#[derive(Clone, Debug)]
pub struct CommandLine {
    /// The options, with their defaults.
    pub options: Options,
    /// Names of the fields that were given.
    pub given: BTreeSet<String>,
}

impl FromArgMatches for CommandLine {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let is_given = |id: &&clap::Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
        let given = matches.ids().filter(is_given).map(|id| id.to_string()).collect();
        Ok(CommandLine { options: Options::from_arg_matches(matches)?, given })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = CommandLine::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for CommandLine {
    fn augment_args(command: clap::Command) -> clap::Command {
        Options::augment_args(command)
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Options::augment_args_for_update(command)
    }
}

/// Reads the value of `--eds`.
///
/// # Errors
/// A text with what was wrong and what is allowed.
pub fn own_sheet(text: &str) -> Result<NodeFile, String> {
    node_and_file(text, MASTER, "3=heater.eds")
}

/// The value of `--cut-at`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutAt {
    /// No cut in this run, and no other fault.
    Never,
    /// Virtual seconds after the start.
    Second(f64),
}

impl FromStr for CutAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "never" {
            return Ok(CutAt::Never);
        }
        match text.parse::<f64>() {
            Ok(second) if second.is_finite() && second >= 0.0 => Ok(CutAt::Second(second)),
            _ => Err("allowed are seconds from 0 to the value of --seconds, or \"never\"".into()),
        }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    seconds_within(text, &SECONDS)
}

/// Reads seconds of the command line.
///
/// # Errors
/// When they are outside of the range.
pub fn seconds_within(text: &str, range: &RangeInclusive<f64>) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if range.contains(&seconds) => Ok(seconds),
        _ => Err(format!("allowed are seconds from {} to {}", range.start(), range.end())),
    }
}

impl Default for Options {
    /// Returns the options of a command line without options.
    fn default() -> Self {
        let command = Options::augment_args(clap::Command::new("fly"));
        Options::from_arg_matches(&command.get_matches_from(["fly"])).expect("every option has a default")
    }
}

impl Options {
    /// Checks conditions between options of boards and images.
    ///
    /// # Errors
    /// When no slave of the whole protocol is left, straps cannot number all slaves, or two images are given for one node.
    pub fn check(&self) -> Result<(), Misuse> {
        self.fleet.check("fly", &self.nodes())?;
        for (option, numbers) in [("--place <N=METRES>", &self.places), ("--crystal <N=PPM>", &self.crystals)]
        {
            if let Some(NodeNumber { node, number }) =
                numbers.iter().find(|given| !self.nodes().contains(&given.node))
            {
                let cause = format!("no board is node {node}; give the Node-ID of one that runs");
                return Err(Misuse::value("fly", option, format_args!("{node}={number}"), cause));
            }
        }
        let wrong = |option, value, cause: String| Err(Misuse::value("fly", option, value, cause));
        let (slaves, minimal, one_controller) = (self.fleet.slaves, self.minimal, self.one_controller);
        if self.fleet.slaves().is_empty() {
            let cause = "no slave is left; allowed are 1 to 14, or 0 with --slave N=FILE";
            return wrong("--slaves <N>", 0, cause.into());
        }
        let room = LAST + 1 - FIRST - slaves;
        if minimal > room {
            let cause = format!(
                "beside {slaves} other slaves allowed are 0 to {room}, as straps number nodes up to {LAST}; or give a smaller \
                 --slaves"
            );
            return wrong("--minimal <N>", minimal, cause);
        }
        if one_controller > minimal {
            let cause = format!("allowed are 0 to {minimal}, the value of --minimal");
            return wrong("--one-controller <N>", one_controller, cause);
        }
        let board = &self.fleet.target.board;
        if one_controller > 0 && board.model().pins.transceiver_switch.is_none() {
            let cause = format!(
                "the description of the board {} has no transceiver-switch; allowed is 0, or a board with one",
                board.name()
            );
            return wrong("--one-controller <N>", one_controller, cause);
        }
        Ok(())
    }

    /// All boards, the master first.
    pub fn nodes(&self) -> BTreeSet<Node> {
        self.fleet.masters().into_iter().chain(self.fleet.slaves()).chain(self.places_of_minimal()).collect()
    }

    /// Node-IDs of minimal slaves that are no images of the user's.
    pub fn minimal_nodes(&self) -> BTreeSet<Node> {
        self.places_of_minimal().filter(|node| self.fleet.own_image(*node).is_none()).collect()
    }

    /// Those of them with one controller.
    pub fn one_controller_nodes(&self) -> BTreeSet<Node> {
        let first = self.places_of_minimal().end - self.one_controller;
        self.minimal_nodes().split_off(&first)
    }

    fn places_of_minimal(&self) -> Range<Node> {
        let first = FIRST + self.fleet.slaves;
        first..first + self.minimal
    }

    /// Builds the images that the user has not given.
    ///
    /// # Errors
    /// When an image cannot be built or read, or with `--no-build` was not built before.
    pub fn add_shipped(&self, images: &mut Images) -> anyhow::Result<()> {
        let one_controller = self.one_controller_nodes();
        self.fleet.add_minimal(&(&self.minimal_nodes() - &one_controller), "", images)?;
        self.fleet.add_minimal(&one_controller, "+one-controller", images)?;
        self.fleet.add_shipped(&self.nodes(), images)
    }

    /// Returns the second of the cut, or with two masters that of the loss of the active one; `None` for a run without
    /// faults.
    ///
    /// # Errors
    /// When the cut is after the end of the run.
    pub fn cut_second(&self) -> Result<Option<f64>, Misuse> {
        match self.cut_at {
            None if !self.faults.is_empty() => Ok(None),
            None => Ok(Some(self.seconds / 2.0)),
            Some(CutAt::Never) => Ok(None),
            Some(CutAt::Second(cut)) if cut <= self.seconds => Ok(Some(cut)),
            Some(CutAt::Second(cut)) => {
                let end = self.seconds;
                let allowed = format!("allowed are 0 to {end} (or \"never\"), or a longer --seconds");
                let cause = format!("the flight ends at {end} s; {allowed}");
                Err(Misuse::value("fly", "--cut-at <S>", cut, cause))
            }
        }
    }

    /// Returns place, crystal and power-on of a node, as far as they are given. Options replace entries of a mission file.
    pub fn setup(&self, node: Node) -> Setup {
        let number =
            |of: &[NodeNumber]| of.iter().rev().find(|given| given.node == node).map(|given| given.number);
        let file = self.setups.get(&node).copied().unwrap_or_default();
        Setup {
            place_m: number(&self.places).or(file.place_m),
            crystal_ppm: number(&self.crystals).or(file.crystal_ppm),
            ..file
        }
    }

    /// Checks that files can be written to `--out`, before long work begins.
    ///
    /// # Errors
    /// When the directory cannot be made or written to.
    pub fn prepare_out(&self) -> Result<(), Misuse> {
        project::make_writable(&self.out).map_err(|cause| {
            let cause = format!("{cause}; give a directory that can be created and written to");
            Misuse::value("fly", "--out <DIR>", self.out.display(), cause)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_folder_is_in_the_target_directory() {
        let out = Options::default().out;
        assert!(out.is_absolute() && out.ends_with("fly"), "{}", out.display());
        let target = out.parent().expect("the target directory");
        assert!(target.join(".rustc_info.json").is_file(), "{}", target.display());
    }
}
