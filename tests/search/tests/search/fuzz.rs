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

/// Given any requests, then only complete, valid downloads change values, and after silence the server serves again.
#[test]
fn an_sdo_server_takes_any_requests() {
    try_target("sdo-server");
}

/// Given any answers, then a transfer always ends, and delivers the data of the frames.
#[test]
fn an_sdo_client_takes_any_answers() {
    try_target("sdo-client");
}

/// Given any configuration, then only mapped values change, to the bits of the frame, and no invalid mapping becomes
/// active.
#[test]
fn pdos_can_be_configured_with_anything() {
    try_target("pdo-mapping");
}

/// Given any module control, then the state follows the state diagram, and heartbeats carry it.
#[test]
fn a_slave_takes_any_module_control() {
    try_target("nmt");
}

/// Given any frames on both buses, then a slave stays alive.
#[test]
fn a_slave_takes_anything_from_its_buses() {
    try_target("slave");
}
