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
fn figures_repeat_on_stdout_and_in_the_summary() {
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

    let again = bench(&out, &["--only", "irq", "--json"]);
    assert_eq!(rows(&out), first, "the same figures");
    let printed: Value = serde_json::from_slice(&again.stdout).expect("JSON on stdout");
    assert_eq!(printed, first);
}
