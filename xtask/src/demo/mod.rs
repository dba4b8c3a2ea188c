//! `cargo demo`: one flight of the spacecraft, told, recorded and judged.

mod files;
pub mod flight;
pub mod message;
pub mod mission;
mod narrator;
pub mod observer;
mod options;
mod outcome;
pub mod plan;
pub mod record;
mod report;
#[cfg(test)]
pub mod sample;
mod stamps;
mod summary;
mod telemetry;

use anyhow::bail;
use can_wire::time::Time;
use indicatif::{ProgressBar, ProgressStyle};

pub use options::Options;
use plan::{PROFILE, Plan};
use summary::Summary;

/// Flies, tells, writes and judges.
///
/// # Errors
/// When an image cannot be built, a file cannot be written, or the flight was not a good one.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let plan = Plan::new(options).unwrap_or_else(|misuse| misuse.exit());
    options.prepare_out().unwrap_or_else(|misuse| misuse.exit());
    let images = firmware_images::build(options.board.name(), PROFILE.name())?;

    let progress = progress(plan.end);
    let flight = mission::fly(plan, &images, |now, lines| {
        progress.set_position(now.as_us() / 1000);
        if !lines.is_empty() {
            progress.suspend(|| lines.iter().for_each(|line| println!("{}", line.styled())));
        }
    });
    progress.finish_and_clear();
    let flight = flight?;

    let summary = Summary::of(&flight);
    let faults = summary::faults(&flight);
    files::write(&options.out, &flight, &summary, &faults)?;
    println!("\n{}\nWritten to {}: {}", outcome::text(&flight, &summary), options.out.display(), files::LIST);
    if !faults.is_empty() {
        bail!("the flight failed: {}", faults.join("; "));
    }
    Ok(())
}

/// A bar on a terminal, nothing elsewhere.
fn progress(end: Time) -> ProgressBar {
    let bar = ProgressBar::new(end.as_us() / 1000);
    let template = "{bar:40.cyan/blue} {pos} of {len} ms of virtual time, {elapsed} on this computer";
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
