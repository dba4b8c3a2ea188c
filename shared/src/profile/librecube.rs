//! The numbers of the LibreCube prototype of 2017.

use super::{Profile, STANDARD};
use crate::nmt::NodeId;
use crate::time::Duration;

/// Heartbeat 250 ms, SYNC 5 s, time 10 s, a command and a telemetry request to each slave every 0.1 s. Slave 4 has
/// selective access, so that both ways to fail over are seen.
pub const LIBRECUBE: Profile = Profile {
    name: "librecube",
    heartbeat: Duration::from_millis(250),
    consumer: Duration::from_millis(2_500),
    ttoggle: 5,
    ntoggle: 10,
    sync: Duration::from_millis(5_000),
    time: Duration::from_millis(10_000),
    command: Duration::from_millis(100),
    telemetry: Duration::from_millis(100),
    selective: &[NodeId::of::<4>()],
    ..STANDARD
};
