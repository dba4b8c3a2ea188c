//! Searches all states of the redundancy, or shows how a defect is found.

use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, ValueEnum};
use model::defect::Defect;
use model::world::Crew;
use search::states::evidence::Evidence;
use search::states::{self, MOST_FAULTS, snapshot};

/// Searches all that can happen to a master and two slaves on two buses with some faults at any moment.
///
/// Exit codes: 0 every property holds in every state, and the number of states is the known one; 1 not so; 2 wrong arguments.
#[derive(Parser)]
struct Arguments {
    /// Faults at most, 0 to 3
    #[arg(long, default_value_t = MOST_FAULTS, value_parser = clap::value_parser!(u8).range(..=i64::from(MOST_FAULTS)))]
    faults: u8,
    /// Who manages the network
    #[arg(long, value_enum, default_value_t = Masters::One)]
    masters: Masters,
    /// Threads, 1 to 64: all cores unless given
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: Option<u8>,
    /// Breaks a rule from outside of the machines, and prints the shortest way to where that shows
    #[arg(long, value_name = "RULE")]
    broken: Option<Defect>,
}

/// Master boards.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Masters {
    /// A master without a standby
    One,
    /// The same in use: boot process, bus-off, applications, budgets
    OneInUse,
    /// The same as one, and no slave is assigned
    OneUnassigned,
    /// Two boards, one of which is the standby of the other
    Two,
    /// The same with equal clocks: equal frames merge
    TwoInStep,
    /// The same, and no slave is assigned
    TwoUnassigned,
    /// A master without a standby, and one slave that reports an error and a value
    OneWithReports,
    /// The same with two boards
    TwoWithReports,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(defect) = arguments.broken {
        return show(defect);
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let start = Instant::now();
    let crew = match arguments.masters {
        Masters::One => Crew::OneMaster,
        Masters::OneInUse => Crew::OneMasterInUse,
        Masters::OneUnassigned => Crew::OneMasterUnassigned,
        Masters::Two => Crew::TwoMasters,
        Masters::TwoInStep => Crew::TwoMastersInStep,
        Masters::TwoUnassigned => Crew::TwoMastersUnassigned,
        Masters::OneWithReports => Crew::OneMasterWithReports,
        Masters::TwoWithReports => Crew::TwoMastersWithReports,
    };
    let report = states::search(crew, arguments.faults, arguments.threads.map_or(cores, usize::from));
    for violation in &report.violations {
        println!("does not hold: {}\n\n{}", violation.property, violation.table);
    }
    if !report.is_closed {
        eprintln!("the search ended at a property that does not hold, after {} states", report.states);
        return ExitCode::FAILURE;
    }
    println!(
        "{} states and {} steps with up to {} faults, all of them: every property holds\n\
         longest time without service {} ms, longest disagreement {} ms, most changes of the bus without need {}\n\
         longest time with two active masters that hear each other {} ms, most changes of role {}\n\
         longest time in which a master did not know what a slave had reported {} ms\n\
         {:.0} s",
        report.states,
        report.steps,
        arguments.faults,
        report.unserved,
        report.disagreeing,
        report.needless,
        report.rivalling,
        report.handed_over,
        report.unknown,
        start.elapsed().as_secs_f64()
    );
    match snapshot::states(crew, arguments.faults) {
        Some(known) if known == report.states => ExitCode::SUCCESS,
        known => {
            eprintln!(
                "{known:?} states are known in {}: put the new number there if a rule has changed",
                snapshot::PATH
            );
            ExitCode::FAILURE
        }
    }
}

fn show(defect: Defect) -> ExitCode {
    let evidence = Evidence::of(defect);
    let Some(violation) = evidence.search(evidence.faults) else {
        eprintln!("not found with {} faults", evidence.faults);
        return ExitCode::FAILURE;
    };
    println!("{defect:?}: does not hold: {}\n\n{}", violation.property, violation.table);
    ExitCode::SUCCESS
}
