//! Recording on disk during a run: frames of each bus and of both, and log lines of the boards.

use std::io::Write;
use std::path::Path;

use anyhow::Context;
use can_twin::spacecraft::WireRecord;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

use crate::fly::files::{self, FrameFiles, Writer};

/// Files that are being written.
pub struct Recording {
    frames: FrameFiles,
    said: Writer,
}

impl Recording {
    /// Begins a recording in a directory, which is created if missing. An earlier recording there is overwritten.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn begin(directory: &Path) -> anyhow::Result<Recording> {
        std::fs::create_dir_all(directory)
            .with_context(|| format!("cannot make the directory {}", directory.display()))?;
        let frames = FrameFiles::begin(directory)?;
        Ok(Recording { frames, said: files::begin(directory, "boards.log")? })
    }

    /// Records a completed frame of one of the two buses.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn frame(&mut self, record: &WireRecord) -> anyhow::Result<()> {
        match &record.record {
            Observation::Completed { trace, .. } => self.frames.write(record.bus, trace.end, &trace.frame),
            _ => Ok(()),
        }
    }

    /// Records a log line of a board.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn line(&mut self, at: Time, board: &str, text: &str) -> anyhow::Result<()> {
        Ok(writeln!(self.said, "{:10.6}  {board}  {text}", at.as_secs_f64())?)
    }

    /// Completes the recording.
    ///
    /// # Errors
    /// When the rest cannot be written.
    pub fn end(mut self) -> anyhow::Result<()> {
        self.frames.finish()?;
        Ok(self.said.flush()?)
    }
}
