//! `cargo demo`: one flight of the spacecraft, told, recorded and judged.

mod flight;
mod message;
mod narrator;
mod observer;
mod options;
mod outcome;
mod plan;
mod record;
mod report;
#[cfg(test)]
mod sample;
mod summary;
mod telemetry;

pub use options::Options;

/// Flies, tells, writes and judges.
///
/// # Errors
/// When an image cannot be built, a file cannot be written, or the flight was not a good one.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let plan = plan::Plan::new(options).unwrap_or_else(|misuse| misuse.exit());
    options.prepare_out().unwrap_or_else(|misuse| misuse.exit());
    anyhow::bail!("no twin yet {plan:?}")
}
