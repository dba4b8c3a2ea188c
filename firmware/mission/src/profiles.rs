//! The three profiles of the mission.

use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::link::bit_timing::BitRate;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Address, Duration, NodeId};

/// Period of the master's commands to each slave, and time in which CAN may repeat a command.
pub const COMMAND_PERIOD: Duration = Duration::from_millis(100);
/// Period of the master's telemetry requests to each slave.
pub const TELEMETRY_PERIOD: Duration = Duration::from_millis(100);

/// The defaults: 1 Mbit/s, heartbeat and SYNC 100 ms, parallel access everywhere, no slave assigned.
pub const STANDARD: Profile = Profile { name: "standard", ..Profile::DEFAULT };

/// The defaults with two master boards, one of them the standby of the other (ECSS 8.1a). They boot slaves 2 to 4, none
/// of which is mandatory.
pub const TWO_MASTERS: Profile = Profile {
    name: "standby",
    slaves: &[slave(NodeId::of::<2>()), slave(NodeId::of::<3>()), slave(NodeId::of::<4>())],
    settings: &[
        error_behaviour(NodeId::of::<2>()),
        error_behaviour(NodeId::of::<3>()),
        error_behaviour(NodeId::of::<4>()),
    ],
    standby: Some(Profile::PAIR),
    ..STANDARD
};

/// The profile that images of the mission are built with.
pub const PROFILE: &Profile = &NUMBERS.at(BIT_RATE).checked();

const NUMBERS: Profile = if cfg!(feature = "standby") {
    TWO_MASTERS
} else if cfg!(feature = "librecube") {
    LIBRECUBE
} else {
    STANDARD
};

const BIT_RATE: BitRate = if cfg!(feature = "kbit-10") {
    BitRate::KBIT_10
} else if cfg!(feature = "kbit-20") {
    BitRate::KBIT_20
} else if cfg!(feature = "kbit-50") {
    BitRate::KBIT_50
} else if cfg!(feature = "kbit-125") {
    BitRate::KBIT_125
} else if cfg!(feature = "kbit-250") {
    BitRate::KBIT_250
} else if cfg!(feature = "kbit-500") {
    BitRate::KBIT_500
} else {
    BitRate::MBIT_1
};

// Checks all profiles, also those that an image does not use.
const _: [Profile; 3] = [STANDARD.checked(), TWO_MASTERS.checked(), LIBRECUBE.checked()];

/// The numbers of the LibreCube prototype of 2017: heartbeat 250 ms, SYNC 5 s, time 10 s. Slaves 4 and 6 have selective
/// access, to show both ways of fail-over. Slave 6, if present, is a minimal slave. The master boots slaves 2 to 4,
/// none of which is mandatory.
pub const LIBRECUBE: Profile = Profile {
    name: "librecube",
    heartbeat: Duration::from_millis(250),
    consumer: Duration::from_millis(2_500),
    ttoggle: 5,
    ntoggle: 10,
    sync: Duration::from_millis(5_000),
    time: Duration::from_millis(10_000),
    selective: &[NodeId::of::<4>(), NodeId::of::<6>()],
    minimal: &[MinimalNode { node: NodeId::of::<6>(), has_heartbeat: true }],
    slaves: &[slave(NodeId::of::<2>()), slave(NodeId::of::<3>()), slave(NodeId::of::<4>())],
    settings: &[
        consumer(NodeId::of::<2>()),
        error_behaviour(NodeId::of::<2>()),
        consumer(NodeId::of::<3>()),
        error_behaviour(NodeId::of::<3>()),
        consumer(NodeId::of::<4>()),
        error_behaviour(NodeId::of::<4>()),
    ],
    ..STANDARD
};

/// Returns a slave of this mission with its product code; the date of its configuration is 25 September 2017, noon.
const fn slave(node: NodeId) -> AssignedSlave {
    let expected = Expected { device_type: 0, identity: [0, 0x5015, 0, 0], stamp: [12_321, 43_200_000] };
    AssignedSlave { node, mandatory: false, expected }
}

/// Returns the setting that a slave consumes the heartbeat of the master, 2.5 s, as at power-on.
const fn consumer(node: NodeId) -> Setting {
    Setting { node, at: Address::new(0x1016, 1), value: &[0xC4, 0x09, 1, 0] }
}

/// Returns the setting that a missed heartbeat of another slave has no effect: the master decides what to do.
const fn error_behaviour(node: NodeId) -> Setting {
    Setting { node, at: Address::new(0x1029, 1), value: &[1] }
}
