//! Stamps of the frames of a port.

use ecss_can::link::Stamp;
use ecss_can::types::Frame;

/// Source of the stamps of frames.
pub trait FrameStamps {
    /// Returns the stamp of a frame: `reported`, that of its interrupt, if there is no better one. `bit`: length of a
    /// bit in ticks of the capture timer. `alone`: whether no later frame like this one has been received or sent.
    fn stamp(&self, frame: &Frame, reported: Stamp, bit: u32, alone: impl FnOnce() -> bool) -> Stamp;
}

/// Frames keep the stamps of their interrupts.
pub struct Interrupts;

impl FrameStamps for Interrupts {
    fn stamp(&self, _: &Frame, reported: Stamp, _: u32, _: impl FnOnce() -> bool) -> Stamp {
        reported
    }
}
