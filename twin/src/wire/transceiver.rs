//! Delays of the transceiver of a node.

use crate::wire::fine::Fine;

/// Delays of one transceiver with its isolation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transceiver {
    /// Delay from the controller's output to the line, nanoseconds.
    pub driver_ns: u32,
    /// Delay from the line to the controller's input, nanoseconds.
    pub receiver_ns: u32,
}

impl Transceiver {
    /// Makes a transceiver with a loop delay, out and in together, of `loop_ns` nanoseconds: half in each direction, an
    /// odd one in the receiver.
    pub const fn with_loop(loop_ns: u32) -> Transceiver {
        let driver_ns = loop_ns / 2;
        Transceiver { driver_ns, receiver_ns: loop_ns - driver_ns }
    }

    pub(in crate::wire) fn delays(self) -> [Fine; 2] {
        [self.driver_ns, self.receiver_ns].map(|ns| Fine::from_ratio(u64::from(ns) * 336, 1000))
    }
}
