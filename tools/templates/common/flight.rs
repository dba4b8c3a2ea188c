//! The flight of `mission.toml` on emulated boards, by the program `ecss-can`.

use std::env;
use std::path::Path;
use std::process::Command;

/// Path of the program where it is not in PATH.
const VARIABLE: &str = "ECSS_CAN";

/// Given the images of this folder on emulated boards, when the flight of `mission.toml` ends, then all its criteria are met.
#[test]
fn mission_meets_its_criteria() {
    let program = env::var_os(VARIABLE).unwrap_or("ecss-can".into());
    let report = Path::new(env!("CARGO_TARGET_TMPDIR")).join("flight");
    let flight = Command::new(program)
        .arg("fly")
        .arg("--out")
        .arg(&report)
        .output();
    let flight = flight.expect("install ecss-can, or set ECSS_CAN to its path");
    let [stdout, stderr] =
        [flight.stdout, flight.stderr].map(|said| String::from_utf8_lossy(&said).into_owned());
    assert!(flight.status.success(), "{stdout}\n{stderr}");
    assert!(report.join("report.html").is_file());
}
