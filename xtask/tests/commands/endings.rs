//! A command whose output has no reader.

use second::programs::PIPE_CLOSED;

use crate::XTASK;

#[test]
fn closed_stdout_ends_every_command_quietly() {
    let here = tempfile::tempdir().expect("a temporary directory");
    let out = |name: &str| here.path().join(name).to_str().expect("UTF-8").to_owned();
    let arguments = ["bench", "--only", "irq", "--out", &out("rows.json")];
    let (code, stderr) = XTASK.run_with_closed_stdout(&arguments);
    assert_eq!(code, PIPE_CLOSED, "{arguments:?}: {stderr}");
    assert!(!stderr.contains("panicked") && !stderr.contains("error"), "{arguments:?}: {stderr}");
}
