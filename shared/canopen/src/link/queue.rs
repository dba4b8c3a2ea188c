//! Transmit queue of a bus: the lowest COB-ID first, each frame with its lifetime.
//!
//! Frames of one COB-ID keep their order. In a full queue a frame that the network depends on displaces one that it
//! does not depend on: see [`is_vital`].

use thiserror::Error;

use heapless::vec::VecInner;

use super::depth::Depth;
use super::port::is_urgent;
use crate::types::{Canonical, CobId, Frame, Instant};

/// Function code of NMT error control.
const HEARTBEATS: u16 = 0x700;

/// Frame that waits for transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outgoing {
    /// Frame to send.
    pub frame: Frame,
    /// End of the lifetime. From this instant on the frame is not sent.
    #[canonical(due)]
    pub expires: Instant,
}

impl Outgoing {
    /// Returns whether the lifetime has ended.
    pub fn is_expired(&self, now: Instant) -> bool {
        self.expires <= now
    }
}

/// The queue is full, and did not take the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the transmit queue is full")]
pub struct Full;

/// Priority queue of frames, with the number of places of `D`.
pub struct TxQueue<D: Depth> {
    /// Sorted by COB-ID, the next to go last; equal COB-IDs in reverse order of arrival.
    frames: VecInner<Outgoing, usize, D::Of<Outgoing>>,
}

impl<D: Depth> Default for TxQueue<D> {
    fn default() -> Self {
        Self::new()
    }
}

impl<D: Depth> TxQueue<D> {
    /// Makes an empty queue.
    #[inline]
    pub fn new() -> Self {
        TxQueue { frames: D::list() }
    }

    /// Puts a frame behind those of its COB-ID. In a full queue a [vital](is_vital) frame displaces the frame
    /// that is not vital and would be sent last. The displaced frame is returned.
    ///
    /// # Errors
    /// [`Full`] if all places are taken and no frame can be displaced.
    pub fn push(&mut self, outgoing: Outgoing) -> Result<Option<Outgoing>, Full> {
        let id = outgoing.frame.id();
        let displaced = if !self.frames.is_full() {
            None
        } else if is_vital(id)
            && let Some(last) = self.frames.iter().position(|queued| !is_vital(queued.frame.id()))
        {
            self.take(last)
        } else {
            return Err(Full);
        };
        self.insert(outgoing, id.raw() + 1)?;
        Ok(displaced)
    }

    /// Puts back a frame that was taken, in front of those of its COB-ID.
    ///
    /// # Errors
    /// [`Full`]: no frame is displaced.
    pub(crate) fn put_back(&mut self, outgoing: Outgoing) -> Result<(), Full> {
        self.insert(outgoing, outgoing.frame.id().raw())
    }

    /// Inserts a frame so that identifiers from `later` on go after it.
    #[inline(never)] // from two places
    fn insert(&mut self, outgoing: Outgoing, later: u16) -> Result<(), Full> {
        let mut carried = outgoing;
        if self.frames.is_full() {
            return Err(Full);
        }
        for queued in self.frames.iter_mut().skip_while(|queued| queued.frame.id().raw() >= later) {
            core::mem::swap(queued, &mut carried);
        }
        self.frames.push(carried).map_err(|_| Full)
    }

    /// Returns whether there is no frame.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Returns the next frame to send, without taking it.
    pub fn peek(&self) -> Option<&Outgoing> {
        self.frames.last()
    }

    /// Takes the next frame to send.
    pub fn pop(&mut self) -> Option<Outgoing> {
        self.frames.pop()
    }

    /// Takes one frame whose lifetime has ended.
    pub fn pop_expired(&mut self, now: Instant) -> Option<Outgoing> {
        let at = self.frames.iter().position(|queued| queued.is_expired(now))?;
        self.take(at)
    }

    /// Takes a frame out; those behind it move up.
    #[inline(never)] // from two places, both rare
    fn take(&mut self, at: usize) -> Option<Outgoing> {
        let mut carried = self.frames.pop()?;
        for queued in self.frames.iter_mut().skip(at).rev() {
            core::mem::swap(queued, &mut carried);
        }
        Some(carried)
    }

    /// Returns the earliest end of a lifetime.
    pub fn next_expiry(&self) -> Option<Instant> {
        self.frames.iter().map(|queued| queued.expires).min()
    }
}

/// Returns whether the network depends on frames with this COB-ID: the [urgent](is_urgent) ones and heartbeats.
pub fn is_vital(id: CobId) -> bool {
    is_urgent(id) || id.function() == HEARTBEATS
}
