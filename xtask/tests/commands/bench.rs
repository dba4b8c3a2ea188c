//! `bench` on the command line: its file, and reproducible figures.

use std::path::Path;

use serde_json::Value;

use crate::XTASK;

fn rows(out: &Path) -> Value {
    let text = std::fs::read_to_string(out).expect("the summary is written");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn figures_repeat_in_the_summary() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = here.path().join("new/summary.json");
    let irq = ["bench", "--only", "irq", "--out", out.to_str().expect("UTF-8")];
    assert_eq!(XTASK.run(&irq).0, 0);
    let first = rows(&out);
    let row = &first["irq.cut_bus"];
    assert_eq!([&row["unit"], &row["better"]], ["interrupts_per_second", "lower"]);
    let compiler = first["toolchain"]["value"].as_str();
    assert!(compiler.is_some_and(|compiler| compiler.starts_with("rustc ")), "{first}");

    assert_eq!(XTASK.run(&irq).0, 0);
    assert_eq!(rows(&out), first, "the same figures");
}
