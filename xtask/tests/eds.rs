//! `eds` through the command line: what it writes, and that the files of the documentation are current.

use std::path::Path;
use std::process::{Command, Output};

fn eds(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).arg("eds").args(arguments).output().expect("xtask starts")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Verifies: ECSS 6.6a
#[test]
fn the_committed_files_are_those_of_the_code() {
    let output = eds(&["--check"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_stale_or_missing_file_is_named_and_left_alone() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().to_str().unwrap();
    assert!(eds(&["--out", out]).status.success());
    assert!(eds(&["--out", out, "--check"]).status.success());

    let path = here.path().join("slave-3.dcf");
    std::fs::write(&path, "changed").unwrap();
    let output = eds(&["--out", out, "--check"]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(complaint.contains("slave-3.dcf") && complaint.contains("cargo xtask eds"), "{complaint}");
    assert!(!complaint.contains("slave.eds"), "{complaint}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "changed");

    std::fs::remove_file(&path).unwrap();
    assert_eq!(eds(&["--out", out, "--check"]).status.code(), Some(1));
    assert!(!path.exists());
}

#[test]
fn every_slave_that_is_named_gets_its_dcf() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().join("new").join("eds");
    let arguments =
        ["--slave", "2", "--slave", "127", "--profile", "standard", "--out", out.to_str().unwrap()];
    let output = eds(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(&out), ["master.dcf", "master.eds", "slave-127.dcf", "slave-2.dcf", "slave.eds"]);
    let dcf = std::fs::read_to_string(out.join("slave-127.dcf")).unwrap();
    assert!(dcf.contains("\nNodeID=127\n") && dcf.contains("profile standard\n"));
}

#[test]
fn the_bit_rates_are_those_that_the_clock_of_the_boards_can_make() {
    let here = tempfile::tempdir().expect("a temporary directory");
    assert!(eds(&["--out", here.path().to_str().unwrap()]).status.success());
    let text = std::fs::read_to_string(here.path().join("slave.eds")).unwrap();
    let rates: Vec<&str> = text.lines().filter(|line| line.starts_with("BaudRate_")).collect();
    // 42 MHz is no multiple of 800 kHz.
    let expected = [
        "BaudRate_10=1",
        "BaudRate_20=1",
        "BaudRate_50=1",
        "BaudRate_125=1",
        "BaudRate_250=1",
        "BaudRate_500=1",
        "BaudRate_800=0",
        "BaudRate_1000=1",
    ];
    assert_eq!(rates, expected);
}

#[test]
fn a_node_that_is_no_slave_is_refused() {
    for node in ["0", "1", "128"] {
        let output = eds(&["--slave", node]);
        assert_eq!(output.status.code(), Some(2), "{node}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("2..=127"));
    }
}

/// The example's program on the host prints them; `--package` writes them.
#[test]
fn a_package_of_the_user_gets_its_files() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().to_str().unwrap();
    let output = eds(&["--package", "thermometer", "--slave", "5", "--out", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(names(here.path()), ["thermometer-5.dcf", "thermometer.eds"]);
    let read = |name| std::fs::read_to_string(here.path().join(name)).unwrap();
    assert!(read("thermometer.eds").contains("ParameterName=Calibration table"));
    assert!(read("thermometer-5.dcf").contains("NodeID=5"));
}

#[test]
fn a_package_without_data_sheet_is_refused_with_what_to_do() {
    let output = eds(&["--package", "slave"]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        complaint.contains("slave printed no data sheet") && complaint.contains("eds::slave_program"),
        "{complaint}"
    );
}

#[test]
fn a_missing_manifest_is_named() {
    let output = eds(&["--package", "thermometer", "--manifest-path", "nowhere/Cargo.toml"]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(complaint.contains("nowhere/Cargo.toml: no such file"), "{complaint}");
}
