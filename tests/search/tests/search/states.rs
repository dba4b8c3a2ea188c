//! The search is complete and reproducible, and finds defects.

use std::process::Command;

use clap::ValueEnum;
use model::defect::Defect;
use model::world::Crew;
use search::states::evidence::Evidence;
use search::states::{search, snapshot};

fn breaks_no_property(faults: u8, crews: impl Iterator<Item = Crew>) {
    for crew in crews {
        let report = search(crew, faults, 2);
        assert!(report.is_closed, "{:#?}", report.violations.first().map(|violation| &violation.table));
        assert_eq!(Some(report.states), snapshot::states(crew, faults), "see {}", snapshot::PATH);
    }
}

/// Given up to one fault at any time, then every property holds in every reachable state.
#[test]
fn one_fault_at_any_moment_breaks_no_property() {
    breaks_no_property(1, Crew::ALL.into_iter());
}

/// Given up to two faults at any time, then every property holds in every reachable state. Searches with reports have
/// too many states for a test and are run manually.
#[test]
fn two_faults_at_any_moment_break_no_property() {
    let is_short = |crew: &Crew| !matches!(crew, Crew::OneMasterWithReports | Crew::TwoMastersWithReports);
    breaks_no_property(2, Crew::ALL.into_iter().filter(is_short));
}

/// Given a defect outside the machines, then the search finds a state in which its property does not hold, with the
/// known number of faults and not with fewer.
#[test]
fn each_defect_is_found() {
    for evidence in Defect::value_variants().iter().map(|defect| Evidence::of(*defect)) {
        let violation = evidence.search(evidence.faults).unwrap_or_else(|| panic!("{evidence:?}"));
        assert_eq!(violation.faults, usize::from(evidence.faults), "{evidence:?}\n{}", violation.table);
        assert!(evidence.search(evidence.faults - 1).is_none(), "{evidence:?} with fewer faults");
    }
}

#[test]
fn bad_arguments_end_with_2() {
    for bad in [["--faults", "4"], ["--threads", "0"], ["--broken", "all"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_search")).args(bad).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2), "{bad:?}");
    }
}
