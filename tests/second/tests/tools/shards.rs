//! Shards of a campaign, run by GNU parallel as docs/verification/campaign.md shows it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use ecss_can_cli::images::support::needs::PARALLEL;
use second::{program, tools};

/// Options of the campaign: each shard has two runs.
const CAMPAIGN: [&str; 7] = ["campaign", "--runs", "8", "--seed", "7", "--jobs", "1"];

fn executable() -> &'static Path {
    program::executable().unwrap_or_else(|failure| panic!("{failure:#}"))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the output of a command that must succeed.
fn succeed(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{command:?}: {}\n{}", output.status, text(&output.stderr));
    text(&output.stdout)
}

/// Merges the parts in a folder that match `*.json`.
fn merge(parts: &Path) -> Output {
    let files = fs::read_dir(parts).expect("a folder").map(|entry| entry.expect("a file").path());
    let json = files.filter(|path| path.extension().is_some_and(|extension| extension == "json"));
    Command::new(executable()).args(["campaign", "merge"]).args(json).output().expect("it starts")
}

fn is_refused(parts: &Path, expected: &[&str]) {
    let output = merge(parts);
    let stderr = text(&output.stderr);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(1), String::new()), "{stderr}");
    assert!(expected.iter().all(|part| stderr.contains(part)), "{expected:?}: {stderr}");
}

/// Given a campaign in four shards, when GNU parallel runs them, then the merged table is that of one run. When the part of a shard
/// is removed or cut off, then `merge` names this shard. When it has run again, then the table is complete.
#[test]
fn merged_shards_of_gnu_parallel_give_one_table() {
    tools::require(&[PARALLEL]).unwrap_or_else(|failure| panic!("{failure:#}"));
    let version = succeed(Command::new("parallel").arg("--version"));
    assert!(
        version.starts_with("GNU parallel"),
        "install Debian's package parallel, not moreutils: {version}"
    );
    let here = tempfile::tempdir().expect("a temporary directory");
    let (one, parts) = (here.path().join("one"), here.path().join("parts"));
    let expected = succeed(Command::new(executable()).args(CAMPAIGN).arg("--out").arg(&one));
    assert!(expected.contains("8 runs in world host") && expected.contains("\n0 violations"), "{expected}");

    let parallel = |shards: &[&str], out: &Path| {
        let mut command = Command::new("parallel");
        command.args(["--will-cite", "--quote", "--jobs", "2"]).arg(executable()).args(CAMPAIGN);
        command.args(["--shard", "{}/4", "--out"]).arg(out).arg(":::").args(shards);
        succeed(&mut command);
    };
    parallel(&["1", "2", "3", "4"], &parts);
    let merged = merge(&parts);
    assert_eq!(text(&merged.stdout), expected, "{}", text(&merged.stderr));

    let third = parts.join("host-3-of-4.json");
    let whole = fs::read(&third).expect("a part");
    fs::remove_file(&third).expect("it is there");
    is_refused(&parts, &["of 4 shards these are missing: 3"]);
    fs::write(&third, &whole[..whole.len() / 2]).expect("a file");
    is_refused(&parts, &["host-3-of-4.json: no part of", "of 4 shards these are missing: 3"]);

    // Only the lost shard runs again.
    parallel(&["3"], &parts);
    assert_eq!(text(&merge(&parts).stdout), expected);
}
