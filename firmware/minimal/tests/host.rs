//! The minimal slave as a program on a computer.

use std::process::Command;

fn minimal(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_minimal")).args(arguments).output();
    let output = output.expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Given a run of 8 s with a cut after 5 s, then the minimal slave executes commands before it, follows the master to the redundant
/// bus, and executes commands there.
///
/// Verifies: ECSS 8.3.3d, 9.4.2a, 9.4.3a, 9.4.9.1.1a
#[test]
fn minimal_program_shows_the_fail_over() {
    let (code, text) = minimal(&["--seconds", "8", "--cut-at", "5"]);
    assert_eq!(code, Some(0));
    let (before, after) =
        text.split_once("5.000000  spacecraft  the nominal bus is cut").expect("there is a cut");
    assert!(before.contains("nominal     TC to node 6: SetLed(true)") && before.contains("state LED on"));
    assert!(before.contains("nominal     TM of node 6: Uptime(1000)"));
    assert!(!before.contains("  redundant "));
    assert!(after.contains("minimal     INFO  active bus: Redundant"));
    assert!(after.contains("redundant   heartbeat of node 6: Operational"));
    assert!(after.contains("redundant   TC to node 6: SetLed(true)") && after.contains("state LED on"));
}

#[test]
fn minimal_program_refuses_wrong_arguments() {
    assert_eq!(minimal(&["--seconds", "1.5"]), (Some(2), String::new()));
}
