//! Python scripts and how they are run.

use std::process::Command;

use anyhow::{Context, ensure};

use crate::program::Twin;
use crate::tools;

/// Runs a script of `python/` against a spacecraft that `cargo twin` flies with `arguments`.
///
/// The script finds the addresses of the buses in `SLCAN_NOMINAL` and `SLCAN_REDUNDANT`.
///
/// # Errors
/// When a tool is missing, the script fails, or a board was not well: with all that script and spacecraft said.
pub fn run(name: &str, arguments: &[&str]) -> anyhow::Result<()> {
    let twin = Twin::start(arguments)?;
    let buses = [("SLCAN_NOMINAL", twin.nominal.as_str()), ("SLCAN_REDUNDANT", &twin.redundant)];
    judge(name, &buses).with_context(|| format!("the spacecraft said\n{}", twin.said()))?;
    twin.end()
}

/// Runs a script of `python/` with these variables in its environment.
///
/// # Errors
/// When Python is missing, or the script fails or tests nothing: with all that it said.
pub fn judge(name: &str, variables: &[(&str, &str)]) -> anyhow::Result<()> {
    let output = Command::new(tools::python()?)
        .arg(tools::scripts().join(name))
        .envs(variables.iter().copied())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .with_context(|| format!("cannot run {name}"))?;
    let said =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    ensure!(output.status.success(), "{name} failed ({})\n{said}", output.status);
    let tested = said.lines().any(|line| line.starts_with("Ran ") && !line.starts_with("Ran 0 "));
    ensure!(tested, "{name} tested nothing\n{said}");
    Ok(())
}
