//! Files of a flight, and the files of frames that `cargo twin` records: one of each bus for can-utils, and one of both
//! for Wireshark.

use std::fs::File;
use std::io::{BufWriter, ErrorKind};
use std::path::Path;

use anyhow::Context;
use can_twin::wire::candump::CandumpWriter;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::pcapng::PcapngWriter;
use can_twin::wire::time::Time;

use super::curves;
use super::flight::Flight;
use super::pdos::Sheets;
use super::record::Bus;
use super::report;
use super::summary::Summary;

/// List of the files, for messages.
pub const LIST: &str = "bus-nominal.log, bus-redundant.log, spacecraft.pcapng, report.html, timeline.svg, clocks.svg, summary.json";

/// Removes the files of an earlier flight, and nothing else.
///
/// # Errors
/// When a file exists and cannot be removed.
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
pub fn write(out: &Path, flight: &Flight, sheets: &Sheets, summary: &Summary) -> anyhow::Result<()> {
    let put = |name: &str, content: &[u8]| {
        let path = out.join(name);
        std::fs::write(&path, content).with_context(|| format!("cannot write {}", path.display()))
    };
    let mut frames = FrameFiles::begin(out)?;
    flight.frames().try_for_each(|(at, seen)| frames.write(seen.bus, at, &seen.frame))?;
    frames.finish()?;
    put("report.html", report::page(flight, &curves::of(flight, sheets), summary).as_bytes())?;
    put("timeline.svg", report::timeline(flight).as_bytes())?;
    put("clocks.svg", report::clocks(flight).as_bytes())?;
    put("summary.json", (serde_json::to_string_pretty(summary)? + "\n").as_bytes())
}

/// A file that is being written.
pub type Writer = BufWriter<File>;

/// Begins a file of a directory.
///
/// # Errors
/// When it cannot be written.
pub fn begin(directory: &Path, name: &str) -> anyhow::Result<Writer> {
    let path = directory.join(name);
    let file = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(BufWriter::new(file))
}

/// `bus-nominal.log`, `bus-redundant.log` and `spacecraft.pcapng`, while they are being written.
pub struct FrameFiles {
    buses: [CandumpWriter<Writer>; 2],
    both: PcapngWriter<Writer>,
}

impl FrameFiles {
    /// Creates the files in an existing directory. Earlier files are overwritten.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn begin(directory: &Path) -> anyhow::Result<FrameFiles> {
        let bus = |bus: Bus| {
            let file = begin(directory, &format!("bus-{}.log", bus.name()))?;
            anyhow::Ok(CandumpWriter::new(file, bus.name()))
        };
        let both = PcapngWriter::new(begin(directory, "spacecraft.pcapng")?, &Bus::ALL.map(Bus::name))?;
        Ok(FrameFiles { buses: [bus(Bus::Nominal)?, bus(Bus::Redundant)?], both })
    }

    /// Adds a frame, if its bus is one of the two.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&mut self, bus: Bus, at: Time, frame: &WireFrame) -> anyhow::Result<()> {
        if let Some(nth) = Bus::ALL.iter().position(|other| *other == bus) {
            self.buses[nth].write(at, frame)?;
            self.both.write(nth, at, frame)?;
        }
        Ok(())
    }

    /// Completes the files.
    ///
    /// # Errors
    /// When the rest cannot be written.
    pub fn finish(self) -> anyhow::Result<()> {
        for bus in self.buses {
            bus.finish()?;
        }
        self.both.finish()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    #[test]
    fn every_frame_stands_in_the_log_of_its_bus() {
        let here = tempfile::tempdir().unwrap();
        let flight = sample::flight();
        write(here.path(), &flight, &Sheets::default(), &sample::summary(&flight)).unwrap();
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
