//! A small fixed share of the campaign.

use campaign::script::Script;
use campaign::{World, fly, fly_run};

/// Runs of seed 1: each kind of fault alone, and as the first of two.
const RUNS: u64 = 38;

/// Flies the runs on all cores; gives what they violate, with their scripts.
fn violations(runs: std::ops::Range<u64>) -> Vec<String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    std::thread::scope(|scope| {
        let share = |core| {
            let numbers = runs.clone().filter(move |number| number % cores == core);
            scope.spawn(move || {
                let flown = numbers.map(|number| {
                    let (script, outcome) = fly_run(World::Host, 1, number);
                    (number, outcome.violations, script)
                });
                let bad = flown.filter(|(_, violations, _)| !violations.is_empty());
                bad.map(|(number, violations, script)| format!("run {number}: {violations:#?}\n{script}"))
                    .collect::<Vec<_>>()
            })
        };
        let threads: Vec<_> = (0..cores).map(share).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("a run catches its panics")).collect()
    })
}

#[test]
fn share_of_the_campaign_violates_nothing() {
    let bad = violations(0..RUNS);
    assert!(bad.is_empty(), "{} of {RUNS}:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn equal_scripts_give_equal_outcomes() {
    let script = Script::random(3, 17, 0);
    assert_eq!(fly(World::Host, &script), fly(World::Host, &script));
}
