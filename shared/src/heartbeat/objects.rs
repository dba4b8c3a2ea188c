//! Objects 1016h and 1017h: whose heartbeats a node consumes, and how often it sends its own.

use core::fmt::Debug;

use super::check_entry;
use crate::od::Objects;
use crate::types::{AbortCode, Address};

/// Object 1017h.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct HeartbeatProducer {
    /// Producer heartbeat time
    ///
    /// Milliseconds.
    #[object(0x1017, rw)]
    pub time: u16,
}

/// Object 1016h with `N` entries, at most 127.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct HeartbeatConsumers<const N: usize = 8> {
    /// Consumer heartbeat time
    ///
    /// Node-ID in bits 16 to 22, milliseconds below.
    #[object(0x1016, array, rw)]
    pub consumer_heartbeat: [u32; N],
}

pub(super) const CONSUMERS: u16 = <HeartbeatConsumers>::CONSUMER_HEARTBEAT.index();

/// Room for the heartbeats that a device consumes: [`HeartbeatConsumers`] of any size.
pub trait ConsumerSlots: Objects + Default + Clone + Debug {
    /// Something for each entry.
    type Each<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Debug;

    /// The same for all entries.
    fn each<X: Copy + Debug>(value: X) -> Self::Each<X>;

    /// The entries.
    fn entries(&self) -> &[u32];

    /// The entries, to be changed.
    fn entries_mut(&mut self) -> &mut [u32];

    /// Whether a client may write `value` there. Other objects are not refused.
    ///
    /// # Errors
    /// As [`check_entry`].
    fn may_write(&self, at: Address, value: u32) -> Result<(), AbortCode> {
        if at.index == CONSUMERS { check_entry(self.entries(), at.sub, value) } else { Ok(()) }
    }
}

impl<const N: usize> ConsumerSlots for HeartbeatConsumers<N> {
    type Each<X: Copy + Debug> = [X; N];

    fn each<X: Copy + Debug>(value: X) -> [X; N] {
        const { assert!(N <= 127, "1016h has at most 127 entries") };
        [value; N]
    }

    fn entries(&self) -> &[u32] {
        &self.consumer_heartbeat
    }

    fn entries_mut(&mut self) -> &mut [u32] {
        &mut self.consumer_heartbeat
    }
}
