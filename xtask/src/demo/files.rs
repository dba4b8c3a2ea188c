//! What a flight leaves on disk.

use std::path::Path;

use anyhow::Context;

use super::flight::Flight;
use super::report;
use super::summary::Summary;

/// The files, for people.
pub const LIST: &str =
    "bus-nominal.log, bus-redundant.log, spacecraft.pcapng, report.html, timeline.svg, summary.json";

/// Writes all of them into a directory that exists.
///
/// # Errors
/// When a file cannot be written.
pub fn write(out: &Path, flight: &Flight, summary: &Summary, faults: &[String]) -> anyhow::Result<()> {
    let put = |name: &str, content: &[u8]| {
        let path = out.join(name);
        std::fs::write(&path, content).with_context(|| format!("cannot write {}", path.display()))
    };
    put("report.html", report::page(flight, summary, faults).as_bytes())?;
    put("timeline.svg", report::timeline(flight).as_bytes())?;
    put("summary.json", (serde_json::to_string_pretty(summary)? + "\n").as_bytes())
}
