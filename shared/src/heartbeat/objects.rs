//! Object 1016h: whose heartbeats a node consumes.

use core::fmt::Debug;

use crate::od::Objects;

/// Object 1016h with `N` entries, at most 127.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct HeartbeatConsumers<const N: usize = 8> {
    /// Consumer heartbeat time
    ///
    /// Node-ID in bits 16 to 22, milliseconds below.
    #[object(0x1016, array, rw)]
    pub consumer_heartbeat: [u32; N],
}

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
