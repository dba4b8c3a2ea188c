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
