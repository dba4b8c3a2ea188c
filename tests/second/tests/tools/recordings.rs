//! Recordings of `cargo demo`, read by third-party tools.

use std::process::Command;

use ecss_can_cli::images::support::needs::{LOG2ASC, TSHARK};
use second::{program, script, tools};

#[test]
fn recordings_of_the_demo_are_read_alike_by_all_tools() {
    tools::require(&[TSHARK, LOG2ASC]).unwrap_or_else(|failure| panic!("{failure:#}"));
    let here = tempfile::tempdir().expect("a temporary directory");
    let output = Command::new(program::executable().unwrap_or_else(|failure| panic!("{failure:#}")))
        .args(["fly", "--slaves", "2", "--seconds", "6", "--cut-at", "3", "--out"])
        .arg(here.path())
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let directory = here.path().to_str().expect("UTF-8");
    script::judge("recordings.py", &[("RECORDINGS", directory)])
        .unwrap_or_else(|failure| panic!("{failure:#}"));
}
