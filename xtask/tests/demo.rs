//! Short flights through the command line: what they write, and that a seed decides everything.

use std::path::Path;
use std::process::{Command, Output};

fn fly(out: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["demo", "--out"])
        .arg(out)
        .args(arguments)
        .output()
        .expect("xtask starts")
}

fn read(out: &Path, name: &str) -> Vec<u8> {
    std::fs::read(out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn a_seed_decides_every_byte_of_the_logs() {
    let flight = |seed: &str| {
        let here = tempfile::tempdir().expect("a temporary directory");
        let output = fly(here.path(), &["--slaves", "1", "--seconds", "2", "--cut-at", "1", "--seed", seed]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let summary: serde_json::Value =
            serde_json::from_slice(&read(here.path(), "summary.json")).expect("JSON");
        assert_eq!(summary["slaves_operational_at_end"], 1);
        assert_eq!(summary["lost_frames"], 0);
        assert!(summary["tc_due"].as_u64() > Some(0));
        assert_eq!(summary["tc_executed"], summary["tc_due"]);
        assert!(summary["failover_ms"]["2"].as_f64() < Some(1000.0), "{summary}");
        ["bus-nominal.log", "bus-redundant.log", "spacecraft.pcapng"].map(|name| read(here.path(), name))
    };
    let first = flight("1");
    assert!(first.iter().all(|file| !file.is_empty()));
    assert!(first == flight("1"), "two flights with one seed differ");
    assert!(first != flight("2"), "another seed makes no difference");
}

#[test]
fn the_other_board_flies_as_well() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let arguments = ["--board", "nucleo-f446re", "--slaves", "1", "--seconds", "2", "--cut-at", "1"];
    let output = fly(here.path(), &arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value =
        serde_json::from_slice(&read(here.path(), "summary.json")).expect("JSON");
    assert_eq!(summary["board"], "nucleo-f446re");
    assert_eq!(summary["slaves_operational_at_end"], 1);
    assert_eq!(summary["lost_frames"], 0);
}

#[test]
fn a_flight_too_short_for_the_selective_slave_fails_and_says_why() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let output = fly(here.path(), &["--seconds", "4", "--cut-at", "1"]);
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("node 4 is pre-operational on the nominal bus at the end"), "{stderr}");
    let report = String::from_utf8(read(here.path(), "report.html")).expect("UTF-8");
    assert!(report.contains("node 4 is pre-operational"), "the report must tell as well");
}
