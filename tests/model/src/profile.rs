//! The parameters of the model: small numbers with the ratios of the default profile.

use ecss_can::link::access::BusAccess;
use ecss_can::profile::Profile;
use ecss_can::redundancy::machine::MasterSetup;
use ecss_can::redundancy::{Pair, Parameters};
use ecss_can::types::{Bus, Duration, NodeId};
use ecss_can_worlds::judge::Bounds;

/// Upper bound of Node-IDs (exclusive).
pub const PLACES: usize = 4;

/// Frames of a master that may wait for the announcement of the bus.
pub const HELD: usize = 8;

/// The slave with parallel access.
pub const PARALLEL: NodeId = NodeId::of::<2>();
/// The slave with selective access.
pub const SELECTIVE: NodeId = NodeId::of::<3>();

/// Step of time: half a heartbeat period. Actions that are due within a tick are done at its end.
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
/// Share with which one silent slave of two is a minority, for which the master tries the other bus.
pub const MINORITY_SHARE: u8 = 100;
/// The dwell is two toggling times and two heartbeat periods: 24 ticks.
pub const DWELL: Duration = Duration::ZERO;
/// Buses have no errors in the model, so nothing waits for their end.
pub const GRACE: Duration = Duration::from_millis(2);
/// Duration for which an application stops a slave, or a budget silences one.
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
/// Period of reads of a slave's error register: never, because they would hide errors that announcements miss. Where
/// there are rounds, [`begin_round`](crate::world::World::begin_round) makes one.
pub const NO_ROUNDS: Duration = Duration::from_micros(u64::MAX);
/// An error that was read from a history may have ended without a message: the master reads the register again 1 s later.
const SECOND_LOOK: Duration = Duration::from_millis(1_000);
/// Duration of a round: the next heartbeat, the questions, and the second read.
const ROUND: Duration = Duration::from_millis(1_500);

/// Returns the longest times for which a rule may be broken after the last fault.
pub fn bounds() -> Bounds {
    Bounds::new(&PARAMETERS, DWELL, &PAIR)
}

/// Returns the whole ticks of a time.
pub fn ticks(span: Duration) -> u8 {
    u8::try_from(span.as_micros() / TICK.as_micros()).unwrap_or(u8::MAX)
}

/// Returns the ticks after the last fault in which the master learns a report without a round.
pub fn without_round() -> u8 {
    ticks(bounds().service + SECOND_LOOK)
}

/// Returns the ticks after the last fault in which the master learns a report with a round.
pub fn with_round() -> u8 {
    without_round() + ticks(ROUND)
}
