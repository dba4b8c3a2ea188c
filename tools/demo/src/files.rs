//! What a flight leaves on disk.

use std::io::ErrorKind;
use std::path::Path;

use anyhow::Context;

use super::flight::Flight;
use super::frames::FrameFiles;
use super::report;
use super::summary::Summary;

/// The files, for people.
pub const LIST: &str = "bus-nominal.log, bus-redundant.log, spacecraft.pcapng, report.html, timeline.svg, clocks.svg, summary.json";

/// Removes those of an earlier flight, and nothing else.
///
/// # Errors
/// When one is there and cannot be removed.
pub fn remove(out: &Path) -> anyhow::Result<()> {
    for path in LIST.split(", ").map(|name| out.join(name)) {
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            outcome => outcome.with_context(|| format!("cannot remove {}", path.display()))?,
        }
    }
    Ok(())
}

/// Writes all of them into a directory that exists.
///
/// # Errors
/// When a file cannot be written.
pub fn write(out: &Path, flight: &Flight, summary: &Summary) -> anyhow::Result<()> {
    let put = |name: &str, content: &[u8]| {
        let path = out.join(name);
        std::fs::write(&path, content).with_context(|| format!("cannot write {}", path.display()))
    };
    let mut frames = FrameFiles::begin(out)?;
    flight.frames().try_for_each(|(at, seen)| frames.write(seen.bus, at, &seen.frame))?;
    frames.finish()?;
    put("report.html", report::page(flight, summary).as_bytes())?;
    put("timeline.svg", report::timeline(flight).as_bytes())?;
    put("clocks.svg", report::clocks(flight).as_bytes())?;
    put("summary.json", (serde_json::to_string_pretty(summary)? + "\n").as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn every_frame_stands_in_the_log_of_its_bus() {
        let here = tempfile::tempdir().unwrap();
        let flight = sample::flight();
        write(here.path(), &flight, &sample::summary(&flight)).unwrap();
        let lines = |bus: &str| -> Vec<String> {
            let log = std::fs::read_to_string(here.path().join(format!("bus-{bus}.log"))).unwrap();
            assert!(log.lines().all(|line| line.contains(&format!(" {bus} "))));
            log.lines().map(String::from).collect()
        };
        let (nominal, redundant) = (lines("nominal"), lines("redundant"));
        assert_eq!(nominal.len() + redundant.len(), flight.frames().count());
        assert!(nominal.contains(&"(0000000000.112000) nominal 702#00".to_owned()));
        for name in LIST.split(", ") {
            assert!(here.path().join(name).metadata().unwrap().len() > 0, "{name}");
        }
    }
}
