//! The emulated core against QEMU.

use std::process::Command;

use ecss_can_cli::images::support::project;

/// Given a program of exceptions, faults, lazy stacking and MPU regions, when QEMU runs it anew, then the emulated core prints the same lines,
/// but for those that `twin/judge/README.md` explains.
#[test]
fn the_emulated_core_prints_what_qemu_prints() {
    let script = project::path("twin/judge/qemu.py");
    let output = Command::new("python3").arg(script).output().unwrap();
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{}\n{out}\n{err}", output.status);
}
