//! valgrind's callgrind: counts the instructions of a program on this computer.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, ensure};
use cargo_metadata::Message;
use cargo_metadata::camino::Utf8PathBuf;
use ecss_can_cli::images::support::project;

/// Target directory of its programs, separate so that they use no flags of other builds.
const TARGET_DIR: &str = "target/bench/build";

/// Builds the program that these arguments of cargo select, in a profile, and returns its path.
///
/// # Errors
/// When it does not compile.
pub fn build(what: &[&str], profile: &str) -> anyhow::Result<PathBuf> {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(project::path("")).args(["build", "--locked", "--quiet", "--profile", profile]);
    cargo.args(["--message-format", "json-render-diagnostics", "--target-dir", TARGET_DIR]).args(what);
    for flags in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTFLAGS"] {
        cargo.env_remove(flags);
    }
    let output = cargo.stderr(Stdio::inherit()).output().context("cannot run cargo")?;
    let what = what.join(" ");
    ensure!(output.status.success(), "{what} cannot be built ({})", output.status);
    let programs = Message::parse_stream(output.stdout.as_slice()).filter_map(|message| match message {
        Ok(Message::CompilerArtifact(artifact)) => artifact.executable,
        _ => None,
    });
    programs
        .last()
        .map(Utf8PathBuf::into_std_path_buf)
        .with_context(|| format!("{what}: cargo names no program"))
}

/// Counts the instructions of a program from its start to its end.
///
/// # Errors
/// When it fails, or valgrind does.
pub fn count(program: &Path, arguments: &[&str]) -> anyhow::Result<u64> {
    let mut valgrind = Command::new("valgrind");
    // Only totals are needed.
    valgrind.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(program).args(arguments);
    let output = valgrind.output().context("cannot run valgrind")?;
    let told = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{} {}: {told}", program.display(), arguments.join(" "));
    total(&told).with_context(|| format!("valgrind has not told how many instructions: {told}"))
}

/// Returns the total from the line `==123== Collected : 456`.
fn total(told: &str) -> Option<u64> {
    let line = told.lines().find(|line| line.contains("Collected :"))?;
    line.split(':').next_back()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_read_from_what_callgrind_tells() {
        let told =
            "==7== Events    : Ir\n==7== Collected : 1203467\n==7== \n==7== I   refs:      1,203,467\n";
        assert_eq!(total(told), Some(1_203_467));
        assert_eq!(total("==7== Events    : Ir\n"), None);
    }
}
