//! `ecss-can doctor`: checks what this computer has for building images and flashing boards.

mod findings;
mod machine;

use clap::Args;
use console::style;
use findings::{Finding, findings};
use machine::Machine;

use crate::images::support::output::{Silently, line};

/// Command line of `doctor`.
#[derive(Args, Debug)]
#[command(after_help = "Exit code 0: images can be built; 1: something for this is missing.")]
pub struct Options {}

/// Prints what is there and what is missing, with commands that install it.
///
/// # Errors
/// [`Silently`] with exit code 1 when images cannot be built.
pub fn run(_: &Options) -> anyhow::Result<()> {
    let findings = findings(&Machine::this());
    findings.iter().try_for_each(print)?;
    if findings.iter().any(Finding::prevents_images) {
        line("Images cannot be built.")?;
        return Err(Silently(1).into());
    }
    line("Images can be built.")
}

fn print(finding: &Finding) -> anyhow::Result<()> {
    match &finding.state {
        Ok(there) => line(format_args!("{} {}: {there}", style("there  ").green(), finding.part)),
        Err(command) => {
            line(format_args!("{} {}, {}:", style("missing").red(), finding.part, finding.purpose()))?;
            line(format_args!("            {command}"))
        }
    }
}
