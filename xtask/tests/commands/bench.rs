//! `bench` through the command line: its file, and that figures repeat.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn bench(out: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["bench", "--out"])
        .arg(out)
        .args(arguments)
        .output()
        .expect("xtask starts")
}

fn rows(out: &Path) -> Value {
    let text = std::fs::read_to_string(out).expect("the summary is written");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn figures_repeat_and_rows_of_other_areas_stay() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().join("new/summary.json");
    assert!(bench(&out, &["--only", "irq"]).status.success());
    let first = rows(&out);
    let row = &first["irq.cut_bus"];
    assert_eq!(
        (row["unit"].as_str(), row["better"].as_str()),
        (Some("interrupts_per_second"), Some("lower"))
    );
    assert!(
        first["toolchain"]["value"].as_str().is_some_and(|compiler| compiler.starts_with("rustc ")),
        "{first}"
    );

    let mut other = first.clone();
    other["wire.of_another_day"] = row.clone();
    std::fs::write(&out, other.to_string()).expect("a file");
    let again = bench(&out, &["--only", "irq", "--json"]);
    assert_eq!(rows(&out), other, "the same figures, and the row of another area");
    let printed: Value = serde_json::from_slice(&again.stdout).expect("JSON on stdout");
    assert_eq!(printed, first);
}

/// Given two areas, when each is measured as a shard, then the merged rows are those of one run, in the file and on stdout. When a
/// part is missing or damaged, it is named, and nothing is written.
#[test]
fn merged_shards_give_the_rows_of_one_run() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let path = |name: &str| here.path().join(name);
    let areas = ["--only", "sync,irq"];
    let one = bench(&path("one.json"), &[&areas[..], &["--json"]].concat());
    let shards = ["1/2", "2/2"].map(|shard| {
        let part = path(&shard.replace('/', "-of-"));
        let output = bench(&part, &[&areas[..], &["--shard", shard]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        part.to_str().expect("UTF-8").to_owned()
    });
    let merge = |files: &[&str], out: &str| {
        let out = path(out);
        let arguments = [&["merge", "--json", "--out", out.to_str().expect("UTF-8")], files].concat();
        Command::new(env!("CARGO_BIN_EXE_xtask")).arg("bench").args(arguments).output().expect("xtask starts")
    };
    let [first, second] = [&*shards[0], &*shards[1]];
    let merged = merge(&[second, first], "merged.json");
    assert_eq!(String::from_utf8_lossy(&merged.stdout), String::from_utf8_lossy(&one.stdout));
    assert_eq!(rows(&path("merged.json")), rows(&path("one.json")));
    assert!(rows(&path("one.json"))["irq.cut_bus"]["holds"].is_boolean());

    std::fs::write(second, &std::fs::read(first).expect("a part")[..200]).expect("a file");
    let damaged = merge(&[first, second], "damaged.json");
    let stderr = String::from_utf8_lossy(&damaged.stderr);
    assert_eq!(damaged.status.code(), Some(1), "{stderr}");
    assert!(
        stderr.contains("2-of-2: no part of a run of `bench`") && stderr.contains("missing: 2"),
        "{stderr}"
    );
    assert!(!path("damaged.json").exists());
}

#[test]
fn a_file_that_is_no_summary_is_left_alone() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().join("summary.json");
    std::fs::write(&out, "not mine").expect("a file");
    let output = bench(&out, &["--only", "irq"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("remove it"));
    assert_eq!(std::fs::read_to_string(&out).expect("still there"), "not mine");
}
