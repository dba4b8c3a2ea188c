//! Stamps of the frames of a port.

use ecss_can::link::Stamp;
use ecss_can::types::Frame;

/// Source of the stamps of frames.
pub trait FrameStamps {
    /// Returns the best stamp of a frame; `reported` is that of its interrupt. `bit`: length of a bit in ticks of the
    /// capture timer. `alone`: returns whether no later frame with the same identifier has been received or sent.
    fn stamp(&self, frame: &Frame, reported: Stamp, bit: u32, alone: impl FnOnce() -> bool) -> Stamp;

    /// Compares the registers of the source with what they have to be, and mends them.
    fn mend(&mut self);
}

/// Frames keep the stamps of their interrupts.
pub struct Interrupts;

impl FrameStamps for Interrupts {
    fn stamp(&self, _: &Frame, reported: Stamp, _: u32, _: impl FnOnce() -> bool) -> Stamp {
        reported
    }

    fn mend(&mut self) {}
}
