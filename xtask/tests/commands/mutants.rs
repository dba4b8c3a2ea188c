//! `cargo xtask mutants` with a cargo-mutants that runs no test: it tells what the test wants it to tell.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

const LIST: &str = "shared/src/lib.rs:1:1: replace one -> u8 with 0\n\
    shared/src/lib.rs:2:1: replace two -> u8 with 0\nshared/src/lib.rs:2:9: delete ! in two\n";

/// A program that lists these mutants. Run with the first configuration, then with the second one, it catches those that
/// `caught` of it names, and misses all others.
fn fake(folder: &Path, caught: [&str; 2]) {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).expect("a file");
    write("list", LIST);
    write("mutants.toml", caught[0]);
    write("mutants-all.toml", caught[1]);
    write("mutants-applications.toml", caught[1]);
    write("mutants-redundancy.toml", caught[0]);
    write("mutants-redundancy-two-faults.toml", caught[1]);
    let here = folder.display();
    let script = format!(
        r#"#!/bin/sh
[ "$1" = mutants ] || exit 1
[ "$2" = --version ] && exit 0
config=$(basename "$3")
[ "$4" = --list ] && exec cat {here}/list
echo "$@" >> {here}/arguments
while [ "$1" != --output ]; do shift; done
mkdir -p "$2/mutants.out" && cd "$2/mutants.out" || exit 1
cat {here}/$config > caught.txt
grep -vxFf caught.txt {here}/list > missed.txt
: > timeout.txt; : > unviable.txt
exit 2
"#
    );
    write("cargo-mutants", &script);
    let permissions = fs::Permissions::from_mode(0o755);
    fs::set_permissions(folder.join("cargo-mutants"), permissions).expect("executable");
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let all = std::env::var_os("PATH").expect("PATH");
    let path = std::env::join_paths(std::iter::once(folder.to_owned()).chain(std::env::split_paths(&all)));
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["mutants", "--out", folder.to_str().expect("UTF-8")])
        .args(arguments)
        .env("PATH", path.expect("folders"))
        .output()
        .expect("xtask starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn what_the_tests_by_clause_miss_meets_all_tests() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let lines: Vec<&str> = LIST.lines().collect();
    fake(here.path(), [&format!("{}\n", lines[0]), &format!("{}\n", lines[2])]);
    let output = run(here.path(), &["--at-least", "66"]);
    let expected = format!(
        "missed: {}\n2 of 3 mutants caught, 1 of them by the tests by clause, 0 by a test that did not end; 0 more do not \
         compile\n",
        lines[1]
    );
    assert_eq!((stdout(&output), output.status.code()), (expected, Some(0)));
    let calls = fs::read_to_string(here.path().join("arguments")).expect("it was called");
    let calls: Vec<&str> = calls.lines().collect();
    assert_eq!(calls.len(), 2);
    assert!(calls[0].contains(".cargo/mutants.toml") && calls[1].contains(".cargo/mutants-all.toml"));
    assert!(
        calls[0].contains("with 0$") && calls[0].contains("replace one") && !calls[1].contains("replace one")
    );

    let output = run(here.path(), &["--by-clause", "--at-least", "33"]);
    assert!(stdout(&output).contains("1 of 3 mutants caught"), "{}", stdout(&output));
    assert_eq!(output.status.code(), Some(0));

    let output = run(here.path(), &["--at-least", "67"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("fewer than 67 percent"), "{stderr}");
}

/// Given mutants of the applications, then their own tests alone run against each, and the tests by clause are not mentioned.
#[test]
fn mutants_of_applications_meet_their_own_tests() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let lines: Vec<&str> = LIST.lines().collect();
    fake(here.path(), ["", &format!("{}\n{}\n", lines[0], lines[2])]);
    let output = run(here.path(), &["--applications", "--at-least", "66"]);
    let expected = format!(
        "missed: {}\n2 of 3 mutants caught, 0 by a test that did not end; 0 more do not compile\n",
        lines[1]
    );
    assert_eq!((stdout(&output), output.status.code()), (expected, Some(0)));
    let calls = fs::read_to_string(here.path().join("arguments")).expect("it was called");
    assert_eq!(calls.lines().count(), 1);
    assert!(
        calls.contains(".cargo/mutants-applications.toml") && calls.contains("--baseline skip"),
        "{calls}"
    );
    let output = run(here.path(), &["--applications", "--at-least", "67"]);
    assert_eq!(output.status.code(), Some(1));
    let output = run(here.path(), &["--applications", "--by-clause"]);
    assert_eq!(output.status.code(), Some(2), "the applications have no tests by clause");
}

/// Given mutants of the machines of redundancy, then the model meets each with one fault, and the missed ones with two.
#[test]
fn mutants_of_the_redundancy_meet_the_model_alone() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let lines: Vec<&str> = LIST.lines().collect();
    fake(here.path(), [&format!("{}\n", lines[0]), &format!("{}\n", lines[2])]);
    let output = run(here.path(), &["--redundancy", "--at-least", "66"]);
    let expected = format!(
        "missed: {}\n2 of 3 mutants caught, 1 of them with one fault, 0 by a test that did not end; 0 more do not compile\n",
        lines[1]
    );
    assert_eq!((stdout(&output), output.status.code()), (expected, Some(0)));
    for other in ["--applications", "--by-clause"] {
        let output = run(here.path(), &["--redundancy", other]);
        assert_eq!(output.status.code(), Some(2), "{other}");
    }
}

#[test]
fn one_seed_draws_one_sample() {
    let here = tempfile::tempdir().expect("a temporary directory");
    fake(here.path(), ["", ""]);
    let list = |arguments: &[&str]| stdout(&run(here.path(), &[&["--list"], arguments].concat()));
    let all = list(&[]);
    let mut sorted: Vec<&str> = all.lines().collect();
    sorted.sort_unstable();
    let mut lines: Vec<&str> = LIST.lines().collect();
    lines.sort_unstable();
    assert_eq!(sorted, lines);
    assert!(all.starts_with(&list(&["--sample", "2"])) && list(&["--sample", "2"]).lines().count() == 2);
    let orders: Vec<String> = (0..20).map(|seed| list(&["--seed", &seed.to_string()])).collect();
    assert_eq!(orders[1], all, "the seed is 1 where none is given");
    assert!(orders.iter().any(|order| *order != all));
}

#[test]
fn wrong_numbers_are_refused() {
    let here = tempfile::tempdir().expect("a temporary directory");
    fake(here.path(), ["", ""]);
    for (option, value, expected) in
        [("--sample", "0", "'0'"), ("--at-least", "101", "'101'"), ("--seed", "x", "'x'")]
    {
        let output = run(here.path(), &[option, value]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(option) && stderr.contains(expected), "{stderr}");
    }
}

/// Given the configurations of cargo-mutants, then each package whose tests they run exists: without its tests every mutant would
/// count as caught.
#[test]
fn packages_that_test_mutants_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .current_dir(root)
        .output();
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.expect("cargo runs").stdout).expect("JSON");
    let known: Vec<&str> = metadata["packages"]
        .as_array()
        .expect("packages")
        .iter()
        .filter_map(|package| package["name"].as_str())
        .collect();
    for name in [
        "mutants.toml",
        "mutants-all.toml",
        "mutants-applications.toml",
        "mutants-redundancy.toml",
        "mutants-redundancy-two-faults.toml",
    ] {
        let text = fs::read_to_string(root.join(".cargo").join(name)).expect(name);
        let config: toml::Table = text.parse().expect(name);
        let packages = config["test_package"].as_array().expect("a list");
        let missing: Vec<_> = packages
            .iter()
            .filter(|package| !known.iter().any(|one| package.as_str() == Some(one)))
            .collect();
        assert!(!packages.is_empty() && missing.is_empty(), "{name}: {missing:?}");
    }
}
