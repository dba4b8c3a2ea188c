//! What happens, on disk while it happens: frames of each bus and of both, and what the boards say.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::Context;
use can_wire::candump::CandumpWriter;
use can_wire::pcapng::PcapngWriter;
use can_wire::record::Observation;
use can_wire::time::Time;
use twin::spacecraft::{Bus, WireRecord};

type Writer = BufWriter<File>;

/// Files that are being written.
pub struct Recording {
    buses: [CandumpWriter<Writer>; 2],
    both: PcapngWriter<Writer>,
    said: Writer,
}

impl Recording {
    /// Begins in a directory, which is made when there is none. An earlier recording there is overwritten.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn begin(directory: &Path) -> anyhow::Result<Recording> {
        std::fs::create_dir_all(directory)
            .with_context(|| format!("cannot make the directory {}", directory.display()))?;
        let file = |name: &str| {
            let path = directory.join(name);
            let file = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
            anyhow::Ok(BufWriter::new(file))
        };
        let bus = |bus: Bus| anyhow::Ok(CandumpWriter::new(file(&format!("bus-{bus}.log"))?, bus.name()));
        Ok(Recording {
            buses: [bus(Bus::Nominal)?, bus(Bus::Redundant)?],
            both: PcapngWriter::new(file("spacecraft.pcapng")?, &Bus::ALL.map(Bus::name))?,
            said: file("boards.log")?,
        })
    }

    /// A frame, if it is one of the two buses that was completed.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn frame(&mut self, record: &WireRecord) -> anyhow::Result<()> {
        if let Observation::Completed { trace, .. } = &record.record
            && let Some(nth) = Bus::ALL.iter().position(|bus| *bus == record.bus)
        {
            self.buses[nth].write(trace.end, &trace.frame)?;
            self.both.write(nth, trace.end, &trace.frame)?;
        }
        Ok(())
    }

    /// A line of a board.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn line(&mut self, at: Time, board: &str, text: &str) -> anyhow::Result<()> {
        Ok(writeln!(self.said, "{:10.6}  {board}  {text}", at.as_secs_f64())?)
    }

    /// Ends it.
    ///
    /// # Errors
    /// When the rest cannot be written.
    pub fn end(mut self) -> anyhow::Result<()> {
        for bus in self.buses {
            bus.finish()?;
        }
        self.both.finish()?;
        Ok(self.said.flush()?)
    }
}
