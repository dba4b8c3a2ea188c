//! The numbers of the model: small, in the proportions of the default profile.

use ecss_can::profile::Profile;
use ecss_can::redundancy::{BusAccess, MasterSetup, Pair, Parameters};
use ecss_can::types::{Bus, Duration, NodeId};

/// Nodes have Node-IDs below.
pub const PLACES: usize = 4;

/// Frames of a master that may wait for the announcement of the bus.
pub const HELD: usize = 8;

/// The slave with parallel access.
pub const PARALLEL: NodeId = NodeId::of::<2>();
/// The slave with selective access.
pub const SELECTIVE: NodeId = NodeId::of::<3>();

/// Time goes on in whole ticks: half a heartbeat period. What is due within a tick is done at its end.
pub const TICK: Duration = Duration::from_millis(50);

/// Heartbeat 2 ticks, consumer time 5, Ttoggle 2. Ntoggle 4 is the least with which slaves search for two dwells.
pub const PARAMETERS: Parameters = Parameters {
    consumer: Duration::from_millis(250),
    producer: Duration::from_millis(100),
    bdefault: Bus::Nominal,
    ttoggle: 2,
    ntoggle: 4,
    ctoggle: 0,
};

/// The master searches without a limit, as in every profile of the mission.
pub const MASTER_PARAMETERS: Parameters = Parameters { ntoggle: Parameters::NO_LIMIT, ..PARAMETERS };

/// Share of silent slaves that moves the master, percent: one of two.
pub const SILENT_SHARE: u8 = 50;
/// The same where one silent slave of two is a minority, for which the master tries the other bus.
pub const MINORITY_SHARE: u8 = 100;
/// The dwell is two toggling times and two heartbeat periods: 24 ticks.
pub const DWELL: Duration = Duration::ZERO;
/// No bus has errors here, so nothing waits for their end.
pub const GRACE: Duration = Duration::from_millis(2);
/// How long an application stops a slave, or a budget silences one.
pub const BREAK: Duration = Duration::from_millis(400);
/// Lifetime of heartbeats, NMT commands and SYNC.
pub const LIFETIME: Duration = PARAMETERS.producer;
/// Redundancy of a master before it takes [`MASTER_PARAMETERS`], which are stored.
pub const MASTER_SETUP: MasterSetup = MasterSetup {
    parameters: Parameters { bdefault: Bus::Redundant, ..MASTER_PARAMETERS },
    silent_share: SILENT_SHARE,
    dwell: DWELL,
    grace: GRACE,
    access: BusAccess::Parallel,
    lifetime: LIFETIME,
};
/// Two master boards: the standby takes over after 8 ticks, boards listen for 14 and 18.
pub const PAIR: Pair = Profile::PAIR;
/// Between two looks at the error register of a slave: none, because they would hide what the announcements miss.
pub const NO_ROUNDS: Duration = Duration::from_micros(u64::MAX);
