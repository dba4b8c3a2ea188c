//! The master learns reports that a slave makes while its bus fails, at every millisecond, see [`host::events`].

use host::events::{flights, fly};
use host::reports::fly_random;

use crate::wrong;

#[test]
fn reports_at_every_millisecond_of_a_failure_are_known_afterwards() {
    let all = flights();
    let wrong = wrong(all.len(), |number| fly(all[number]));
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len(), wrong.join("\n"));
}

/// Given up to three faults and some fifty reports at random moments, as in the first tier, then error and value are known. 600
/// runs; PROPTEST_CASES makes more.
#[test]
fn reports_under_random_faults_are_known_afterwards() {
    let more = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    let runs = more.unwrap_or(600);
    let wrong = wrong(runs, |number| fly_random(1_000 + number as u64));
    assert!(wrong.is_empty(), "{} of {runs}:\n{}", wrong.len(), wrong.join("\n"));
}
