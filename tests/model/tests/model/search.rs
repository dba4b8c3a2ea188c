//! The search is whole, the same in every run, and finds rules that are broken.

use std::process::Command;

use redundancy_model::broken::RULES;
use redundancy_model::search::{find, search};
use redundancy_model::snapshot;
use redundancy_model::world::Crew;

fn breaks_no_property(faults: u8) {
    for crew in Crew::ALL {
        let report = search(crew, faults, 2);
        assert!(report.is_closed, "{:#?}", report.violations.first().map(|violation| &violation.table));
        assert_eq!(Some(report.states), snapshot::states(crew, faults), "see {}", snapshot::PATH);
    }
}

/// Given up to one fault at any moment. Then every property holds in every state that can be reached.
#[test]
fn one_fault_at_any_moment_breaks_no_property() {
    breaks_no_property(1);
}

/// The same with up to two faults.
#[test]
fn two_faults_at_any_moment_break_no_property() {
    breaks_no_property(2);
}

/// Given a rule that is broken; the slow ones are left to the command. Then the search finds a state where its property does not hold, with as many faults as it
/// takes and no fewer.
#[test]
fn each_broken_rule_is_found() {
    for rule in RULES.into_iter().filter(|rule| rule.faults < 3) {
        let violation = find(rule.crew, rule.faults, rule.broken, rule.property).expect("a way to it");
        assert_eq!(violation.faults, usize::from(rule.faults), "{rule:?}\n{}", violation.table);
        assert!(
            find(rule.crew, rule.faults - 1, rule.broken, rule.property).is_none(),
            "{rule:?} with fewer faults"
        );
    }
}

#[test]
fn bad_arguments_end_with_2() {
    for bad in [["--faults", "4"], ["--threads", "0"], ["--broken", "all"]] {
        let output =
            Command::new(env!("CARGO_BIN_EXE_redundancy-model")).args(bad).output().expect("it runs");
        assert_eq!(output.status.code(), Some(2), "{bad:?}");
    }
}
