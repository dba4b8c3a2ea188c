//! Numbers of a mission: bit rate, periods, redundancy parameters, slaves.
//!
//! A *profile* is a constant that all nodes of a mission share, in images, simulations and documents. Start from
//! [`Profile::DEFAULT`], and end with [`Profile::checked`]: values that do not fit each other then do not compile.
//!
//! ```
//! use ecss_can::link::bit_timing::BitRate;
//! use ecss_can::profile::Profile;
//! use ecss_can::types::{Duration, NodeId};
//!
//! const MISSION: Profile = Profile {
//!     name: "mine",
//!     heartbeat: Duration::from_millis(200),
//!     consumer: Duration::from_millis(500),
//!     selective: &[NodeId::of::<4>()],
//!     ..Profile::DEFAULT.at(BitRate::KBIT_500)
//! }
//! .checked();
//! # assert_eq!(MISSION.ttoggle, 2);
//! ```
//!
//! # Limits
//!
//! - Values that a node stores by "save" have priority over those of the profile.
//! - The checks compare the numbers of a profile with each other. `cargo schedule` of the repository computes
//!   the response times of the frames.

mod checks;
mod heartbeats;
mod node_ids;

use crate::boot::{AssignedSlave, BootPolicy, Setting};
use crate::link::access::BusAccess;
use crate::link::bit_timing::{BitRate, Metres, Network, PartsPerMillion};
use crate::link::budget::{BudgetPolicy, Rate};
use crate::link::bus_off::BusOffPolicy;
use crate::redundancy::{Pair, Parameters};
use crate::time::ClockPolicy;
use crate::types::{Bus, CobId, Duration, NodeId};

/// Numbers of a mission.
#[doc(alias("mission", "configuration"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Profile {
    /// Name of the profile on command lines and in reports.
    pub name: &'static str,
    /// Properties of both buses, from which every node computes its bit timing.
    pub network: Network,
    /// Producer heartbeat time (1017h) of every node, in whole milliseconds, 1 to 65,535 ms.
    pub heartbeat: Duration,
    /// Delay of the heartbeats that a slave sends late, at most a tenth of their period: four data frames of
    /// eight bytes, 540 bits. See [`SlaveBuilder::late_heartbeats`](crate::node::SlaveBuilder::late_heartbeats).
    pub late_heartbeat: Duration,
    /// Consumer heartbeat time (1016h), in whole milliseconds, at most 65,535 ms. Longer than `heartbeat`; zero: no
    /// heartbeat is consumed.
    pub consumer: Duration,
    /// Bus after power-on: Bdefault (2000h sub 1).
    pub bdefault: Bus,
    /// Number of consumer times on a bus before a switch: Ttoggle (2000h sub 2).
    pub ttoggle: u8,
    /// Number of switches before a search of a slave ends: Ntoggle (2000h sub 3).
    pub ntoggle: u8,
    /// Number of bus changes of a master that hears no slave: its Ntoggle (2000h sub 3). 0: it changes the bus by
    /// command alone. 255: no limit.
    pub master_ntoggle: u8,
    /// Communication cycle period: time between two SYNCs (1006h).
    pub sync: Duration,
    /// Period of the Spacecraft Time PDO.
    pub time: Duration,
    /// Lifetime of an event-driven PDO that waits for its bus.
    pub event: Duration,
    /// Nodes with selective access. All others have parallel access.
    pub selective: &'static [NodeId],
    /// Share of the slaves whose silence makes the master switch the bus at once, in percent, `1..=100`.
    pub silent_share: u8,
    /// Shortest time that a master stays on a bus while it hears no slave on either. It is never less than two
    /// toggling times and two heartbeat periods.
    pub dwell: Duration,
    /// COB-IDs of frames whose end is measured in hardware if the board can, received and sent. SYNC (1005h) always is
    /// one of them.
    pub stamped: &'static [CobId],
    /// Limits of the crystals of the nodes. The error bound of every clock (2015h) relies on them.
    pub clocks: ClockPolicy,
    /// Time without progress after which server and client abort an SDO transfer.
    pub sdo_timeout: Duration,
    /// Slaves that the master checks, configures and starts (1F81h to 1F88h). It starts all others without a
    /// check.
    pub slaves: &'static [AssignedSlave],
    /// Values that the master writes to these slaves.
    pub settings: &'static [Setting],
    /// Slaves of the minimal set (ECSS 9), none of them in `slaves`. The master neither boots them nor asks for
    /// their device type, and whatever state they report, it does not start them.
    pub minimal: &'static [MinimalNode],
    /// Limits of the time that the network waits for mandatory slaves.
    pub boot: BootPolicy,
    /// Time that errors on a bus may last without an effect: two frames and the error frame between them.
    pub grace: Duration,
    /// Policy for the recovery from bus-off.
    pub bus_off: BusOffPolicy,
    /// Number of frames that a node may send before it silences itself.
    pub budget: BudgetPolicy,
    /// `true`: slaves enter Operational by themselves after boot-up and "reset communication" (ECSS Table 11-1).
    pub autostart: bool,
    /// Parameters of two master boards, one of them the standby of the other (ECSS 8.1a). `None`: one master
    /// board, active at power-on.
    pub standby: Option<Pair>,
}

/// Slave of the minimal set in the profile of its master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MinimalNode {
    /// Node-ID of the slave.
    pub node: NodeId,
    /// `true`: the slave sends a heartbeat. Without one, the master commands it from power-on and never reports
    /// it as lost.
    pub has_heartbeat: bool,
}

impl Profile {
    /// Default profile: 1 Mbit/s, heartbeat 100 ms, SYNC 100 ms. A slave changes the bus by itself after half a
    /// second, and searches for 25.5 s. All nodes have parallel access. No slave is assigned.
    pub const DEFAULT: Profile = Profile {
        name: "default",
        network: Network {
            bit_rate: BitRate::MBIT_1,
            length: Metres(40),
            node_delay: Network::NODE_DELAY,
            oscillator_tolerance: PartsPerMillion(1_000),
            jump_width: Network::JUMP_WIDTH,
        },
        heartbeat: Duration::from_millis(100),
        late_heartbeat: Duration::from_micros(540),
        consumer: Duration::from_millis(250),
        bdefault: Bus::Nominal,
        ttoggle: 2,
        ntoggle: 50,
        master_ntoggle: Parameters::NO_LIMIT,
        sync: Duration::from_millis(100),
        time: Duration::from_millis(1_000),
        event: Duration::from_millis(100),
        selective: &[],
        silent_share: 50,
        dwell: Duration::from_millis(10_000),
        stamped: &[],
        clocks: ClockPolicy::DEFAULT,
        sdo_timeout: Duration::from_millis(500),
        slaves: &[],
        settings: &[],
        minimal: &[],
        boot: BootPolicy { time: Duration::from_millis(5_000), goes_on: false },
        grace: Duration::from_millis(2),
        bus_off: BusOffPolicy {
            pause: Duration::from_millis(10),
            patience: Duration::from_millis(50),
            attempts: 3,
            window: Duration::from_millis(1_000),
        },
        budget: BudgetPolicy {
            cob_id: Rate::new(128, 1_000),
            slave: Rate::new(256, 2_000),
            master: Rate::new(1_024, 6_000),
            heard: Rate::new(512, 3_000),
            silence: Duration::from_millis(5_000),
        },
        autostart: false,
        standby: None,
    };

    /// Parameters of two master boards that fit [`Profile::DEFAULT`]. The standby takes over after 400 ms, before
    /// slaves change the bus.
    pub const PAIR: Pair = Pair {
        consumer: Duration::from_millis(400),
        prime_listens: Duration::from_millis(700),
        second_listens: Duration::from_millis(1_000),
        prime_claims: CobId::new(0x680).unwrap(),
        second_claims: CobId::new(0x681).unwrap(),
    };

    /// Returns the same profile at another bit rate. Times that depend on the bus become longer at a lower rate:
    /// `grace` is 350 bits, `patience` after bus-off four times the 128 x 11 bits of a recovery, `late_heartbeat`
    /// 540 bits. Periods stay as they are: `cargo schedule` checks whether the bus can carry them.
    ///
    /// ```
    /// use ecss_can::link::bit_timing::BitRate;
    /// use ecss_can::profile::Profile;
    /// const MISSION: Profile = Profile { name: "mine", ..Profile::DEFAULT.at(BitRate::KBIT_125) };
    /// assert_eq!(MISSION.grace.as_micros(), 2_800);
    /// assert_eq!(MISSION.late_heartbeat.as_micros(), 4_320);
    /// ```
    #[must_use]
    pub const fn at(self, bit_rate: BitRate) -> Profile {
        let frames = bit_rate.span(350);
        let grace = if frames.as_micros() > self.grace.as_micros() { frames } else { self.grace };
        let late_frames = bit_rate.span(4 * 135);
        let is_slow = late_frames.as_micros() > self.late_heartbeat.as_micros();
        let late_heartbeat = if is_slow { late_frames } else { self.late_heartbeat };
        let recoveries = bit_rate.span(4 * 128 * 11);
        let is_longer = recoveries.as_micros() > self.bus_off.patience.as_micros();
        let patience = if is_longer { recoveries } else { self.bus_off.patience };
        let bus_off = BusOffPolicy { patience, ..self.bus_off };
        Profile { network: Network { bit_rate, ..self.network }, grace, late_heartbeat, bus_off, ..self }
    }

    /// Returns how a node reaches its buses.
    pub fn access(&self, node: NodeId) -> BusAccess {
        if self.selective.contains(&node) { BusAccess::Selective } else { BusAccess::Parallel }
    }

    /// Returns the redundancy parameters of a slave.
    pub const fn redundancy(&self) -> Parameters {
        Parameters {
            consumer: self.consumer,
            producer: self.heartbeat,
            bdefault: self.bdefault,
            ttoggle: self.ttoggle,
            ntoggle: self.ntoggle,
            ctoggle: 0,
        }
    }

    /// Returns the redundancy parameters of the minimal slave `id`. With a consumer time of zero it does not change the
    /// bus and stays on Bdefault. It sends no heartbeat, and its producer time is zero, if [`Profile::minimal`] lists it
    /// without one: other nodes then notice it only by its telemetry.
    pub fn minimal_redundancy(&self, id: NodeId) -> Parameters {
        let is_silent = self.minimal.iter().any(|minimal| minimal.node == id && !minimal.has_heartbeat);
        let redundancy = self.redundancy();
        if is_silent { Parameters { producer: Duration::ZERO, ..redundancy } } else { redundancy }
    }

    /// Returns the redundancy parameters of the master.
    pub const fn master_redundancy(&self) -> Parameters {
        Parameters { ntoggle: self.master_ntoggle, ..self.redundancy() }
    }
}
