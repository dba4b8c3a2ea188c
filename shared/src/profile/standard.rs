//! The defaults.

use super::Profile;
use crate::boot::BootPolicy;
use crate::link::bit_timing::{BitRate, Metres, Network, PartsPerMillion};
use crate::redundancy::BusOffPolicy;
use crate::types::{Bus, CobId, Duration};

/// 1 Mbit/s, heartbeat 100 ms, a slave changes the bus by itself after half a second and searches for 25.5 s; parallel
/// access everywhere.
pub const STANDARD: Profile = Profile {
    name: "standard",
    network: Network {
        bit_rate: BitRate::MBIT_1,
        length: Metres(40),
        node_delay: Network::NODE_DELAY,
        oscillator_tolerance: PartsPerMillion(1_000),
    },
    heartbeat: Duration::from_millis(100),
    consumer: Duration::from_millis(250),
    bdefault: Bus::Nominal,
    ttoggle: 2,
    ntoggle: 50,
    sync: Duration::from_millis(100),
    time: Duration::from_millis(1_000),
    command: Duration::from_millis(100),
    telemetry: Duration::from_millis(100),
    selective: &[],
    silent_share: 50,
    dwell: Duration::from_millis(10_000),
    stamped: &[CobId::SYNC],
    sdo_timeout: Duration::from_millis(500),
    slaves: &[],
    settings: &[],
    boot: BootPolicy { time: Duration::from_millis(5_000), goes_on: false },
    bus_off: BusOffPolicy {
        pause: Duration::from_millis(10),
        patience: Duration::from_millis(50),
        attempts: 3,
        window: Duration::from_millis(1_000),
    },
    autostart: false,
};
