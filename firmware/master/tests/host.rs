//! The master as a program on a computer.

use std::process::Command;

fn master(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_master")).args(arguments).output();
    let output = output.expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Given the program without options, then the master commands three slaves on the nominal bus. When that bus is cut at
/// 4 s, then the master changes to the redundant bus, all three slaves return there, and telemetry is exchanged until
/// the end at 10 s.
///
/// Verifies: ECSS 8.3.3b, 8.3.3d, 8.3.3f
#[test]
fn master_program_shows_the_fail_over() {
    let (code, text) = master(&[]);
    assert_eq!(code, Some(0));
    let (before, after) =
        text.split_once("4.000000  spacecraft  the nominal bus is cut").expect("there is a cut");
    assert!(!before.contains("  redundant "));
    assert!(after.contains("master      WARN  active bus: Redundant, no longer Nominal"));
    assert!(after.contains("indicators  state LED on"));
    let last_second: String = after.lines().filter(|line| line.trim_start().starts_with("9.")).collect();
    for node in [2, 3, 4] {
        assert!(before.contains(&format!("master      INFO  slave {node}: Operational on Nominal")));
        assert!(before.contains(&format!("nominal     TM of node {node}: Uptime")));
        assert!(after.contains(&format!("redundant   heartbeat of node {node}: Operational")));
        assert!(last_second.contains(&format!("redundant   TC to node {node}: ")));
        assert!(last_second.contains(&format!("redundant   TM of node {node}: ")));
    }
}

#[test]
fn master_program_refuses_wrong_arguments() {
    assert_eq!(master(&["--cut-at", "now"]), (Some(2), String::new()));
}
