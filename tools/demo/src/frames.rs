//! Files with the frames of a flight: one of each bus for can-utils, and one of both for Wireshark.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use anyhow::Context;
use can_wire::candump::CandumpWriter;
use can_wire::frame::WireFrame;
use can_wire::pcapng::PcapngWriter;
use can_wire::time::Time;

use super::record::Bus;

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
    /// Begins in a directory that exists. Earlier files are overwritten.
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

    /// Adds a frame of a bus, if it is one of the two.
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

    /// Ends them.
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
