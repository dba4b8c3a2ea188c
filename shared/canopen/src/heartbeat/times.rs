//! Times of heartbeats.

use crate::types::Duration;

/// Times of heartbeats, as 1016h and 1017h have them: at most 65,535 ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeartbeatTimes {
    /// Consumer heartbeat time for the master, node 1: it makes the first entry of 1016h. Zero: the entry stays as the device
    /// has it.
    pub consumer: Duration,
    /// Producer heartbeat time. Zero: no heartbeat.
    pub producer: Duration,
}
