//! `cargo demo`: one flight of the spacecraft, narrated, recorded and judged. [`live`]: `cargo twin`.

mod aborted;
pub mod change;
mod checks;
mod clocks;
pub mod command;
pub mod criterion;
mod curves;
pub mod drawing;
mod emergencies;
mod emergency;
pub mod fault;
mod files;
pub mod flight;
mod follow;
mod line;
pub mod live;
pub mod liveness;
pub mod meaning;
pub mod mission;
mod mission_file;
mod narrator;
pub mod observer;
mod options;
mod origin;
mod outcome;
mod own;
mod own_project;
mod pdos;
pub mod phase;
pub mod plan;
pub mod record;
mod repeats;
pub mod report;
pub mod sample;
pub mod setup;
mod sheet;
mod stack;
pub mod stamps;
mod summary;
mod telemetry;
pub mod track;
mod unheard;
mod unjudged;
mod verdict;

use std::ops::ControlFlow;

use anyhow::bail;
use can_twin::image::Image;
use flight::Interruption;
use meaning::Scope;
use narrator::name;
pub use options::{CommandLine, Options, SEED};
use origin::Origin;
use pdos::Sheets;
use plan::Plan;
use summary::Summary;
use verdict::Outcome;

use crate::images::support::diagnostics::Diagnostics;
use crate::images::support::misuse::Misuse;
use crate::images::support::node::Node;
use crate::images::support::output::{self, Silently};
use crate::images::support::project;
use crate::images::support::stop::Stop;

/// Runs, narrates, records and judges a flight.
///
/// # Errors
/// When an image cannot be read or built, a file cannot be written, or the flight failed.
pub fn run(line: &CommandLine) -> anyhow::Result<()> {
    let mut options = line.options.clone();
    own_project::complete(&mut options, &line.given)?;
    options.check()?;
    let plan = Plan::new(&options)?;
    plan.check_length(&options)?;
    own::build(&mut options.fleet, &mut options.sheets, &options.builds)?;
    let sheets = Sheets::of(&plan, &options.sheets)?;
    sheets.notes().iter().for_each(output::warn);
    sheets.mismatches(&plan).iter().for_each(output::warn);
    let nodes = options.nodes();
    let mut images = options.fleet.own_images("fly", &nodes)?;
    for (node, image) in &images {
        has_counters(*node, image)?;
    }
    options.prepare_out()?;
    // First, so that results of an earlier flight are not mistaken for those of this one.
    files::remove(&options.out)?;
    options.add_shipped(&mut images)?;
    if plan.scope() == Scope::Protocol {
        output::line(outcome::UNKNOWN_IMAGES)?;
    }

    let origin = Origin::of(&plan, &images);
    let stop = Stop::at_ctrl_c()?;
    output::note(format_args!(
        "running {} boards for {} s of virtual time",
        nodes.len(),
        plan.end.as_secs_f64()
    ));
    let template = "{pos} of {len} ms of virtual time, {elapsed} on this computer";
    let progress = output::progress(plan.end.as_us() / 1000, template);
    let mut printed = Ok(());
    let flight = mission::fly(plan, &images, |now, lines| {
        progress.set_position(now.as_us() / 1000);
        if printed.is_ok() && !lines.is_empty() {
            printed = progress.suspend(|| lines.iter().try_for_each(|line| output::line(line.styled())));
        }
        match () {
            () if stop.is_asked() => ControlFlow::Break(Interruption::Asked),
            () if printed.is_err() => ControlFlow::Break(Interruption::Unread),
            () => ControlFlow::Continue(()),
        }
    });
    progress.finish_and_clear();
    let flight = flight?;

    sheets.differences(&flight).iter().for_each(output::warn);
    output::note("writing report, pictures and logs");
    let summary = Summary::of(&flight, origin, &sheets);
    files::write(&options.out, &flight, &sheets, &summary)?;
    printed?;
    output::line(format_args!(
        "\n{}\nWritten to {}: {}",
        outcome::text(&flight, &summary),
        project::shown(&options.out),
        files::LIST
    ))?;
    let reasons = summary.verdict.reasons.join("; ");
    match summary.verdict.outcome {
        Outcome::Passed => Ok(()),
        Outcome::Failed => bail!("the run failed: {reasons}"),
        Outcome::Interrupted => {
            output::warn(format_args!("the run was interrupted: {reasons}"));
            Err(Silently::INTERRUPTED.into())
        }
    }
}

/// Checks that an image of the user's exports its counters, which are read at the end of the flight.
fn has_counters(node: Node, image: &Image) -> Result<(), Misuse> {
    if Diagnostics::is_in(image) {
        return Ok(());
    }
    let name = name(node);
    Err(Misuse::of(
        "fly",
        format!(
            "the image of {name} has no symbol DIAGNOSTICS, its counters: start its node with the one of `ecss-can-stm32f4`, or \
             fly the image by `cargo twin`"
        ),
    ))
}
