//! Pictures of flights of the firmware images.

use std::ops::ControlFlow;

use clap::Parser;
use ecss_can_cli::fly::drawing::Layout;
use ecss_can_cli::fly::drawing::histogram::{self, Row};
use ecss_can_cli::fly::flight::Flight;
use ecss_can_cli::fly::mission;
use ecss_can_cli::fly::plan::Plan;
use ecss_can_cli::fly::report;

/// Quantity of the histogram.
const WHAT: &str = "error of the clock against the master's; each row has its own height";

type Draw = fn() -> anyhow::Result<Vec<(&'static str, String)>>;

/// Functions that draw them, one flight after the other.
pub const PICTURES: [Draw; 3] = [timeline, clocks, histogram];

/// `cargo demo` with its options.
#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    options: ecss_can_cli::fly::Options,
}

fn fly(arguments: &[&str]) -> anyhow::Result<Flight> {
    let CommandLine { options } = CommandLine::parse_from([&["fly"], arguments].concat());
    let mut images = options.fleet.own_images("fly", &options.nodes())?;
    options.add_shipped(&mut images)?;
    mission::fly(Plan::new(&options)?, &images, |_, _| ControlFlow::Continue(()))
}

fn timeline() -> anyhow::Result<Vec<(&'static str, String)>> {
    Ok(vec![("timeline.svg", report::timeline(&fly(&[])?))])
}

fn clocks() -> anyhow::Result<Vec<(&'static str, String)>> {
    Ok(vec![("clocks.svg", report::clocks(&fly(&["--profile", "standard"])?))])
}

/// Draws the errors of a flight of `cargo xtask bench --only time`.
fn histogram() -> anyhow::Result<Vec<(&'static str, String)>> {
    let rows: Vec<Row> = crate::bench::clock_errors()?
        .iter()
        .zip(2..)
        .map(|(errors, node)| report::clocks::row(format!("node {node}"), errors))
        .collect();
    let title = "Histograms of the errors of three clocks, 30 s to 60 s, 100 pulses each second";
    let picture = histogram::draw(title, Layout::WIDE, WHAT, &rows);
    Ok(vec![("clock-histogram.svg", picture.standalone())])
}
