//! Numbers of a node that no object has.

use crate::heartbeat::HeartbeatTimes;
use crate::link::access::BusAccess;
use crate::link::bus_off::BusOffPolicy;
use crate::types::Duration;

/// Numbers of a node that no object has, or that its objects have at power-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Times of heartbeats (1016h, 1017h), in whole milliseconds.
    pub heartbeats: HeartbeatTimes,
    /// Delay of the heartbeats that the node sends late, if it does: so two nodes with one Node-ID hear each other.
    pub late_heartbeat: Duration,
    /// Longest lifetime of a synchronous frame: the time between two SYNCs.
    pub sync: Duration,
    /// Lifetime of an event-driven PDO that waits for its bus.
    pub event: Duration,
    /// Time without progress after which the server aborts an SDO transfer.
    pub sdo_timeout: Duration,
    /// How the node reaches its buses, if it has two.
    pub access: BusAccess,
    /// Policy for the recovery from bus-off.
    pub bus_off: BusOffPolicy,
    /// `true`: the node enters Operational by itself after boot-up (1F80h).
    pub autostart: bool,
}

impl Settings {
    /// Settings for a bus at 1 Mbit/s: a heartbeat each 100 ms, which the master must send within 250 ms, SYNC each 100 ms.
    pub const DEFAULT: Settings = Settings {
        heartbeats: HeartbeatTimes {
            consumer: Duration::from_millis(250),
            producer: Duration::from_millis(100),
        },
        late_heartbeat: Duration::from_micros(540),
        sync: Duration::from_millis(100),
        event: Duration::from_millis(100),
        sdo_timeout: Duration::from_millis(500),
        access: BusAccess::Parallel,
        bus_off: BusOffPolicy {
            pause: Duration::from_millis(10),
            patience: Duration::from_millis(50),
            attempts: 3,
            window: Duration::from_millis(1_000),
        },
        autostart: false,
    };
}
