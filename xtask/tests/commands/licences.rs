//! `cargo xtask licences` with a cargo-deny that only records its arguments.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Output;

use second::programs::fake::{fake, path_without};

use crate::XTASK;

/// PATH has `first` and no other cargo-deny.
fn run(first: &Path, arguments: &[&str]) -> Output {
    let mut licences = XTASK.command(&["licences"]);
    licences.args(arguments).env("PATH", path_without("cargo-deny", Some(first)));
    licences.output().expect("xtask starts")
}

/// Returns the arguments of a program, on one line.
fn arguments(folder: &Path) -> String {
    fs::read_to_string(folder.join("arguments")).expect("it was called").replace('\n', " ")
}

#[test]
fn a_refusal_of_a_package_fails_the_check() {
    let here = tempfile::tempdir().expect("a temporary directory");
    for (code, expected) in [(0, Some(0)), (4, Some(1))] {
        fake(here.path(), "cargo-deny", code);
        let output = run(here.path(), &[]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), expected, "{stderr}");
        assert_eq!(stderr.contains("deny.toml says what is allowed"), code != 0, "{stderr}");
        let called = arguments(here.path());
        assert!(called.starts_with("--locked check ") && called.contains("licenses"), "{called}");
    }
}

#[test]
fn missing_program_is_reported_with_two_ways_to_install_it() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let output = run(here.path(), &["--root", "nowhere"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    for part in ["nowhere", "cargo xtask licences --install", "cargo install cargo-deny --locked"] {
        assert!(stderr.contains(part), "no {part:?} in\n{stderr}");
    }
}

/// Given a machine without cargo-deny, then its version is pinned, and only `--install` builds it.
#[test]
fn installed_version_is_pinned() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let root = here.path().join("tools");
    fake(here.path(), "cargo", 0);
    let output = run(here.path(), &["--install", "--root", root.to_str().expect("UTF-8")]);
    assert_eq!(output.status.code(), Some(1), "nothing was installed by the program that only writes");
    let called = arguments(here.path());
    assert!(called.starts_with("install cargo-deny --version 0.") && called.contains("--locked"), "{called}");
    assert!(called.contains(&format!("--root {}", root.display())), "{called}");
}
