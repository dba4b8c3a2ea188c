//! The command line: help, wrong values, exit codes.

use crate::XTASK;

#[test]
fn the_commands_for_the_repository_are_listed_with_help() {
    let listed = XTASK.subcommands();
    let names: Vec<&str> = listed.iter().map(|(name, _)| name.as_str()).collect();
    let measuring = ["selftest", "bench", "sizes", "pictures"];
    let checks = ["compliance", "api", "licences", "mutants", "release", "test-all", "clippy", "chips"];
    assert_eq!(names, [&measuring[..], &checks, &["help"]].concat());
    assert!(listed.iter().all(|(_, help)| !help.is_empty()), "{listed:?}");
}

#[test]
fn without_a_command_the_help_is_shown() {
    let (code, _, stderr) = XTASK.run(&[]);
    assert_eq!(code, 2);
    assert!(stderr.contains("Usage: cargo xtask <COMMAND>"), "{stderr}");
}

#[test]
fn an_unknown_area_is_refused_with_the_known_ones() {
    XTASK.refuses(
        &["bench", "--only", "weather"],
        &["weather", "--only", "size", "rx", "load", "failover", "twin"],
    );
    XTASK.refuses(&["sizes", "--symbols", "-1"], &["--symbols", "-1"]);
}

#[test]
fn unwritable_rows_are_refused_before_anything_is_measured() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("file");
    std::fs::write(&file, "in the way").expect("a file");
    let below = file.join("rows.json");
    for command in ["bench", "sizes"] {
        let usage = format!("Usage: cargo xtask {command}");
        XTASK.refuses(&[command, "--out", below.to_str().expect("UTF-8")], &["--out <FILE>", &usage]);
        XTASK.refuses(&[command, "--out", here.path().to_str().expect("UTF-8")], &["is a directory", &usage]);
    }
}
