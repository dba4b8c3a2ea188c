//! Every target on its corpus and on a fixed number of inputs from a fixed seed.

use search::fuzz::campaign::Campaign;

const EXECUTIONS: u64 = 5_000;
const SEED: u64 = 50_15;

fn try_target(name: &str) {
    let mut campaign = Campaign::new(search::fuzz::target(name).unwrap(), SEED);
    let tried = campaign.replay().and_then(|()| campaign.run(EXECUTIONS));
    if let Err(failure) = tried {
        panic!("{name}: {}\n{:02X?}", failure.message, failure.input);
    }
    assert!(campaign.steps() > 50, "inputs that do nothing: {} steps", campaign.steps());
}

/// Only complete, valid downloads change anything; after silence the server serves again.
#[test]
fn an_sdo_server_takes_any_requests() {
    try_target("sdo-server");
}

/// A transfer always ends; what it delivers is what the frames carried.
#[test]
fn an_sdo_client_takes_any_answers() {
    try_target("sdo-client");
}

/// Only what is mapped changes, to the bits of the frame; no invalid mapping becomes active.
#[test]
fn pdos_can_be_configured_with_anything() {
    try_target("pdo-mapping");
}

/// The state follows the state diagram, and heartbeats tell it.
#[test]
fn a_slave_takes_any_module_control() {
    try_target("nmt");
}

/// A whole slave between two buses stays alive.
#[test]
fn a_slave_takes_anything_from_its_buses() {
    try_target("slave");
}
