//! `cargo xtask mutants --patch`: defects as patch files. The commands of these patches compile nothing.

use std::fs;
use std::path::{Path, PathBuf};

use crate::XTASK;
use crate::docs::root;

/// A diff that applies: it adds a line to a file of the project.
const DIFF: &str = "--- a/.gitignore\n+++ b/.gitignore\n@@ -1 +1,2 @@\n /target\n+/defect\n";

/// Writes a patch whose command is `cargo` with these arguments.
fn patch(folder: &Path, rule: &str, arguments: &str, finds: &str, diff: &str) -> PathBuf {
    let file = folder.join(format!("{rule}.patch"));
    let head = format!("Rule: {rule}\nDefect: None.\nCommand: cargo {arguments}\nFinds: {finds}\n\n");
    fs::write(&file, head + diff).expect("a file");
    file
}

/// Runs the patches with a copy of the project in `folder`. Returns exit code, stdout and stderr.
fn run(folder: &Path, patches: &[&Path]) -> (i32, String, String) {
    let mut arguments = vec!["mutants", "--out", folder.to_str().expect("UTF-8"), "--patch"];
    arguments.extend(patches.iter().map(|patch| patch.to_str().expect("UTF-8")));
    XTASK.run(&arguments)
}

/// Removes the seconds, which differ from run to run.
fn without_times(text: &str) -> String {
    text.split(|char: char| char.is_ascii_digit()).collect()
}

/// Given all patches of the project, then each has a valid head and applies, and each rule without a requirement has one patch.
#[test]
fn every_patch_of_the_project_applies() {
    let (code, stdout, stderr) = XTASK.run(&["mutants", "--patch", "--list"]);
    assert_eq!(code, 0, "{stderr}");
    // A requirement begins with its clause, a rule with a letter.
    let is_rule = |line: &&str| line.starts_with(|first: char| first.is_ascii_lowercase());
    let mut rules: Vec<&str> = stdout.lines().filter(is_rule).collect();
    rules.sort_unstable();
    let expected = [
        "base-priority: ",
        "bdefault: ",
        "boot-up-message: ",
        "capture-registers: ",
        "capture-timer: ",
        "controller-registers: ",
        "duty-of-node: ",
        "filter-banks: ",
        "foreign-master: ",
        "interrupt-controller: ",
        "interrupt-sources: ",
        "lost-minority: ",
        "pins: ",
        "register-table: ",
        "short-watchdog: ",
        "sign-of-uptime: ",
        "time-base: ",
        "tries-for-ever: ",
        "unconfigured: ",
        "unknown-node: ",
        "unmended-start: ",
        "unprotected-memory: ",
        "unreported-program: ",
        "unsealed-image: ",
        "upset-alarm: ",
        "upset-assignment: ",
        "upset-board: ",
        "upset-clock: ",
        "upset-code: ",
        "upset-index: ",
        "upset-instant: ",
        "upset-refresh: ",
        "upset-rescue: ",
        "upset-schedule: ",
        "upset-state: ",
    ];
    assert_eq!(rules.len(), expected.len(), "{stdout}");
    for (rule, expected) in rules.iter().zip(expected) {
        assert!(rule.starts_with(expected), "{rule}");
    }
}

/// Given the patches that violate requirements, each is in a file with the name of its requirement.
#[test]
fn patch_of_a_requirement_has_its_name() {
    let folder = root().join("xtask/compliance/patches");
    for entry in fs::read_dir(&folder).expect("a folder") {
        let file = entry.expect("a file").path();
        let text = fs::read_to_string(&file).expect("UTF-8");
        let id = text.lines().find_map(|line| line.strip_prefix("Verifies: "));
        assert_eq!(id, file.file_stem().and_then(|name| name.to_str()), "{}", file.display());
    }
}

/// Given patches whose commands fail with the text of the head, fail with another text, and succeed, then the first one is found
/// and the others are not. The commands run in a patched copy, one patch at a time, and the project stays as it is.
#[test]
fn patch_is_found_by_a_failure_with_its_text_alone() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let make = |rule, arguments, finds| patch(here.path(), rule, arguments, finds, DIFF);
    let found = make("right", "no-such-command", "no such command");
    let other = make("other", "no-such-command", "no such rule");
    let good = make("good", "--version", "cargo");
    let before = fs::read(root().join(".gitignore")).expect("a file");

    let (code, stdout, stderr) = run(here.path(), &[&found]);
    assert_eq!(
        (code, without_times(&stdout).as_str()),
        (0, "found: right,  s\n of  found,  s\n"),
        "{stderr}"
    );
    let (code, stdout, stderr) = run(here.path(), &[&found, &other, &good]);
    let expected = "found: right,  s\n\
        not found: other,  s: the command failed without \"no such rule\"\n\
        not found: good,  s: the command succeeded\n of  found,  s\n";
    assert_eq!((code, without_times(&stdout).as_str()), (1, expected), "{stderr}");
    assert!(stderr.contains("2 of 3 defects were not found"), "{stderr}");
    assert_eq!(fs::read(root().join(".gitignore")).expect("a file"), before);
}

/// Given a patch whose command shows a file, then the command gets the patched file.
#[test]
fn command_of_a_patch_runs_on_patched_files() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let diff = "--- /dev/null\n+++ b/tests/broken/Cargo.toml\n@@ -0,0 +1 @@\n+not a manifest\n";
    let arguments = "metadata --manifest-path tests/broken/Cargo.toml";
    let file = patch(here.path(), "patched", arguments, "not a manifest", diff);
    let (code, stdout, stderr) = run(here.path(), &[&file]);
    assert_eq!(code, 0, "{stdout}{stderr}");
}

/// Given two patches, the second of two shards is the second patch.
#[test]
fn shard_is_a_part_of_the_patches() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let files = ["one", "two"].map(|rule| patch(here.path(), rule, "--version", "cargo", DIFF));
    let mut arguments = vec!["mutants", "--list", "--shard", "2/2", "--patch"];
    arguments.extend(files.iter().map(|file| file.to_str().expect("UTF-8")));
    let (code, stdout, stderr) = XTASK.run(&arguments);
    assert_eq!((code, stdout.as_str()), (0, "two: None.\n    cargo --version\n"), "{stderr}");
    XTASK.refuses(&["mutants", "--shard", "2/2"], &["--patch"]);
}

/// Given a patch of a requirement, its commands are those of the tests with its tag, first in the package that it changes.
#[test]
fn commands_of_a_requirement_are_its_tagged_tests() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("6.3b.patch");
    let diff = "--- /dev/null\n+++ b/shared/canopen/src/more.rs\n@@ -0,0 +1 @@\n+// Empty.\n";
    fs::write(&file, format!("Verifies: 6.3b\nDefect: None.\n\n{diff}")).expect("a file");
    let path = file.to_str().expect("UTF-8");
    let (code, stdout, stderr) = XTASK.run(&["mutants", "--list", "--patch", path]);
    assert_eq!(code, 0, "{stderr}");
    let lines: Vec<&str> = stdout.lines().collect();
    assert_eq!(lines[0], "6.3b: None.");
    let command = "    cargo test --profile mutants -p async-canopen --test spec -- --exact ";
    assert!(lines[1].starts_with(command) && lines[1].contains(" sync::"), "{stdout}");
    assert!(lines.iter().any(|line| line.contains("-p ecss-can --test spec")), "{stdout}");
    assert!(!stdout.contains("-p second"), "{stdout}");
}

#[test]
fn patch_that_does_not_apply_is_refused() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let diff = DIFF.replace(" /target", " /another");
    let file = patch(here.path(), "old", "--version", "cargo", &diff);
    let path = file.to_str().expect("UTF-8");
    let parts = [path, "does not apply", ".gitignore", "Usage: cargo xtask mutants"];
    XTASK.refuses(&["mutants", "--patch", path], &parts);
}

#[test]
fn patch_with_a_wrong_head_is_refused() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let file = here.path().join("short.patch");
    let path = file.to_str().expect("UTF-8");
    for (text, expected) in [
        ("Rule: short\n".to_owned() + DIFF, "no line \"Defect: ...\""),
        ("Verifies: 9.9z\nDefect: None.\n".to_owned() + DIFF, "no requirement on software is 9.9z"),
        (
            "Verifies: 8.3.3h\nDefect: None.\nFinds: a\n".to_owned() + DIFF,
            "\"Finds: ...\" beside \"Verifies: ...\"",
        ),
        ("Rule short\n".to_owned() + DIFF, "\"Rule short\" is not allowed before the diff"),
    ] {
        fs::write(&file, text).expect("a file");
        XTASK.refuses(&["mutants", "--patch", path], &[path, expected]);
    }
    XTASK.refuses(&["mutants", "--patch", "nowhere.patch"], &["nowhere.patch"]);
    XTASK.refuses(&["mutants", "--sample", "3", "--patch"], &["--sample", "--patch"]);
}
/// Given the requirements on software, each has a patch that violates it.
#[test]
fn every_requirement_on_software_has_a_patch() {
    let table = fs::read_to_string(root().join("xtask/compliance/data/requirements.csv")).expect("a table");
    let ids = table.lines().filter_map(|row| row.split_once(",software,")).map(|(id, _)| id);
    let patches = root().join("xtask/compliance/patches");
    let missing: Vec<&str> = ids.filter(|id| !patches.join(format!("{id}.patch")).is_file()).collect();
    assert!(missing.is_empty(), "write these patches: {missing:?}");
}
