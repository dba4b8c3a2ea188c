//! The master learns reports that a slave makes while its bus fails, see [`host::events`].
//!
//! Verifies: ECSS 6.4a

use host::events::{flights, fly, jolts};
use host::reports::fly_random;

/// One flight in 67: reports come at three moments of each failure. The second tier flies every millisecond.
#[test]
fn reports_during_a_failure_of_the_bus_are_known_afterwards() {
    let wrong: Vec<String> =
        flights().into_iter().step_by(67).filter_map(|flight| fly(flight).err()).collect();
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}

/// Given a contact of the master that opens for 40 ms, so that another slave acknowledges what the master does not hear and no node
/// misses a heartbeat, then the master knows all of it 10 s later: it asks for the errors, and states have an event timer.
#[test]
fn reports_during_a_jolt_of_the_connector_are_known_ten_seconds_later() {
    let wrong: Vec<String> = jolts().into_iter().filter_map(|flight| fly(flight).err()).collect();
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}

/// Given up to three faults and some fifty reports at random moments of 3.5 s, then the master knows the error and the value that are
/// there. The second tier flies more of them.
#[test]
fn reports_under_random_faults_are_known_afterwards() {
    let wrong: Vec<String> = (0..40).filter_map(|seed| fly_random(seed).err()).collect();
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}
