//! Each script against its spacecraft. Profile `standard` has short periods, `librecube` is patient with its master.

use interop::script;

fn passes(name: &str, arguments: &[&str]) {
    if let Err(failure) = script::run(name, arguments) {
        panic!("{failure:#}");
    }
}

/// Heartbeats, boot-up and SYNC of a spacecraft that nobody disturbs.
///
/// Verifies: ECSS 8.2b
#[test]
fn a_spacecraft_left_alone_is_heard_as_it_should_be() {
    passes("listening.py", &["--profile", "standard", "--slaves", "3"]);
}

/// The canopen package commands slaves whose master it is.
#[test]
fn slaves_obey_a_foreign_nmt_master() {
    passes("nmt.py", &["--profile", "librecube", "--slaves", "2", "--no-master"]);
}

/// Telecommands and telemetry on PDOs.
#[test]
fn telecommands_are_executed_and_telemetry_answers() {
    passes("telemetry.py", &["--profile", "librecube", "--slaves", "2", "--no-master"]);
}

/// The master follows no foreign command, but starts a slave that was set back.
#[test]
fn the_master_brings_slaves_back() {
    passes("master.py", &["--profile", "standard", "--slaves", "2"]);
}
