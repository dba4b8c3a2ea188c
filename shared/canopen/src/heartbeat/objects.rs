//! Objects 1016h and 1017h: the heartbeats that a node consumes, and the period of its own.

use core::fmt::Debug;

use super::check_entry;
use crate::od::Objects;
use crate::types::{AbortCode, Address, Duration};

/// Period of the heartbeat of a node (1017h).
#[doc(alias("1017h", "producer heartbeat time"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct HeartbeatProducer {
    /// Producer heartbeat time
    ///
    /// Milliseconds.
    #[object(0x1017, rw)]
    pub time: u16,
}

impl HeartbeatProducer {
    /// Returns the period, zero for no heartbeat.
    pub(crate) const fn period(&self) -> Duration {
        Duration::from_millis(self.time as u64)
    }
}

/// Nodes whose heartbeats are consumed (1016h): `N` entries, at most 127.
#[doc(alias("1016h", "consumer heartbeat time"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct HeartbeatConsumers<const N: usize = 8> {
    /// Consumer heartbeat time
    ///
    /// Node-ID in bits 16 to 22, milliseconds below.
    #[object(0x1016, array, rw)]
    pub consumer_heartbeat: [u32; N],
}

pub(super) const CONSUMERS: u16 = <HeartbeatConsumers>::CONSUMER_HEARTBEAT.index();

/// Storage for the heartbeats that a device consumes: [`HeartbeatConsumers`] of any size.
pub trait ConsumerSlots: Objects + Default + Clone + Debug {
    /// Array with one element for each entry.
    type Each<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Debug;

    /// Returns an array with the same value for each entry.
    fn each<X: Copy + Debug>(value: X) -> Self::Each<X>;

    /// Returns the entries of 1016h.
    fn entries(&self) -> &[u32];

    /// Returns the entries of 1016h, to be changed.
    fn entries_mut(&mut self) -> &mut [u32];

    /// Checks a `value` that a client writes. Accepts every value for objects of other services.
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
