//! Transmit queue of a bus: lowest COB-ID first, in order within a COB-ID, each frame with its lifetime.

use heapless::Vec;

use super::Frame;
use crate::time::Instant;

/// A frame on its way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outgoing {
    /// What to send.
    pub frame: Frame,
    /// Not to be sent after this instant; `None`: whenever the bus takes it.
    pub expires: Option<Instant>,
}

/// The queue is full; nothing was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Full;

/// A priority queue of at most `N` frames.
#[derive(Debug, Default)]
pub struct TxQueue<const N: usize> {
    /// Sorted by COB-ID, the next to go last; equal COB-IDs in reverse order of arrival.
    frames: Vec<Outgoing, N>,
}

impl<const N: usize> TxQueue<N> {
    /// An empty queue.
    pub const fn new() -> Self {
        TxQueue { frames: Vec::new() }
    }

    /// Queue a frame behind those of its COB-ID.
    ///
    /// # Errors
    /// [`Full`] when there are `N` frames already.
    pub fn push(&mut self, outgoing: Outgoing) -> Result<(), Full> {
        let id = outgoing.frame.id();
        let at = self.frames.partition_point(|queued| queued.frame.id() > id);
        self.frames.insert(at, outgoing).map_err(|_| Full)
    }

    /// The next frame to send.
    pub fn peek(&self) -> Option<&Outgoing> {
        self.frames.last()
    }

    /// Take the next frame.
    pub fn pop(&mut self) -> Option<Outgoing> {
        self.frames.pop()
    }

    /// Take one frame whose lifetime has ended.
    pub fn pop_expired(&mut self, now: Instant) -> Option<Outgoing> {
        let at = self.frames.iter().position(|queued| is_expired(queued.expires, now))?;
        Some(self.frames.remove(at))
    }

    /// The earliest end of a lifetime.
    pub fn next_expiry(&self) -> Option<Instant> {
        self.frames.iter().filter_map(|queued| queued.expires).min()
    }
}

/// Whether a lifetime has ended.
pub fn is_expired(expires: Option<Instant>, now: Instant) -> bool {
    expires.is_some_and(|end| end <= now)
}
