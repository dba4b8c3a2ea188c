//! What happens, on disk while it happens: frames of each bus and of both, and what the boards say.

use std::io::Write;
use std::path::Path;

use anyhow::Context;
use can_wire::record::Observation;
use can_wire::time::Time;
use twin::spacecraft::WireRecord;

use crate::files::{self, FrameFiles, Writer};

/// Files that are being written.
pub struct Recording {
    frames: FrameFiles,
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
        let frames = FrameFiles::begin(directory)?;
        Ok(Recording { frames, said: files::begin(directory, "boards.log")? })
    }

    /// A frame, if it is one of the two buses that was completed.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn frame(&mut self, record: &WireRecord) -> anyhow::Result<()> {
        match &record.record {
            Observation::Completed { trace, .. } => self.frames.write(record.bus, trace.end, &trace.frame),
            _ => Ok(()),
        }
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
        self.frames.finish()?;
        Ok(self.said.flush()?)
    }
}
