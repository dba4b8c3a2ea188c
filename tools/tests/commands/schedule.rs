//! `cargo schedule`: wrong values, and its verdict on the mission.

use crate::{TOOLS, assert_refused};

#[test]
fn wrong_values_of_the_schedule_are_refused() {
    assert_refused(&[
        ("schedule --nodes 0", &["--nodes", "1..=125"]),
        ("schedule --nodes 126", &["--nodes", "1..=125"]),
        ("schedule --bit-rate 300", &["--bit-rate", "250, 500, 800, 1000 kbit/s"]),
        ("schedule --errors 2:0", &["--errors", "0 to 100 errors", "1 to 60000 ms"]),
        ("schedule --profile none", &["--profile", "librecube", "standard"]),
    ]);
}

/// Both profiles meet every deadline at 1 Mbit/s with errors. At 125 kbit/s the bus is too slow for fourteen slaves.
#[test]
fn schedule_of_the_mission_is_judged() {
    for profile in ["standard", "librecube"] {
        let (code, table, _) = TOOLS.run(&["schedule", "--profile", profile, "--errors", "2:10"]);
        assert_eq!(code, 0, "{table}");
        assert!(table.contains("every deadline is met"), "{table}");
        for id in
            ["000h", "080h", "082h", "181h", "18Fh", "302h", "38Fh", "402h", "58Fh", "602h", "701h", "70Fh"]
        {
            assert!(table.lines().any(|line| line.starts_with(id)), "{id} of {table}");
        }
    }
    let (code, table, stderr) = TOOLS.run(&["schedule", "--bit-rate", "125"]);
    assert_eq!(code, 1, "{table}");
    assert!(table.contains("NO BOUND") && stderr.contains("deadlines cannot be met"), "{table}{stderr}");
}
