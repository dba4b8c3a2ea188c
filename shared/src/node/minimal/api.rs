//! What a minimal slave and its device tell each other.

use super::pdos::{MinimalPdos, Payload};
use crate::link::port::Health;
use crate::node::BusCause;
use crate::profile::Profile;
use crate::redundancy::{BusAccess, BusOffPolicy, Parameters};
use crate::types::{Bus, Duration, Instant, NodeId};

/// What a minimal slave does for its mission.
pub trait MinimalDevice: 'static {
    /// Its PDOs.
    const PDOS: MinimalPdos;
    /// Whether SYNC matters to it, also when no PDO follows it.
    const LISTENS_TO_SYNC: bool = false;

    /// Receive PDO `number` (0 is the first) came with `data`, whose last bit was on the bus at `at`. The data say whether that
    /// is a command, a request for telemetry, or both (ECSS 9.4.2). What is returned goes out at once: the number of a transmit
    /// PDO (0 is the first) that is [sent on request](super::Trigger::Request), and its payload.
    ///
    /// A frame may come twice: CAN repeats one whose sender saw an error in its last bit.
    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)>;

    /// A SYNC that ended at `at` asks for transmit PDO `number`. `None`: it has nothing to say.
    fn on_sync(&mut self, number: usize, at: Instant) -> Option<Payload>;
}

/// The numbers of a minimal slave, of a mission's profile or its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Numbers {
    /// How it reaches its two buses.
    pub access: BusAccess,
    /// When it changes the bus by itself. A consumer time of zero: it does not, and stays on Bdefault. A producer time of
    /// zero: it sends no heartbeat.
    pub redundancy: Parameters,
    /// Recovery from bus-off.
    pub bus_off: BusOffPolicy,
    /// How long telemetry may wait for its bus.
    pub lifetime: Duration,
}

impl Numbers {
    /// Those of node `id` in a mission. It follows the master's heartbeat, and sends its own unless
    /// [`Profile::minimal`] says that it has none.
    pub fn of(profile: &Profile, id: NodeId) -> Numbers {
        let is_silent = profile.minimal.iter().any(|minimal| minimal.node == id && !minimal.has_heartbeat);
        let numbers = Numbers {
            access: profile.access(id),
            redundancy: profile.redundancy(),
            bus_off: profile.bus_off,
            lifetime: profile.event,
        };
        if is_silent { numbers.without_heartbeat() } else { numbers }
    }

    /// The same on one bus at a time, for a board with one controller.
    pub const fn on_one_bus(self) -> Numbers {
        Numbers { access: BusAccess::Selective, ..self }
    }

    /// The same without a heartbeat of its own: other nodes learn of it by its telemetry alone.
    pub fn without_heartbeat(self) -> Numbers {
        Numbers { redundancy: Parameters { producer: Duration::ZERO, ..self.redundancy }, ..self }
    }
}

/// What a minimal slave tells its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MinimalEvent {
    /// The bus considered active was confirmed or changed.
    ActiveBus {
        /// Which it is now.
        bus: Bus,
        /// Why.
        cause: BusCause,
    },
    /// The master is missed on the active bus.
    MasterMissed {
        /// The active bus.
        bus: Bus,
    },
    /// Ntoggle switches in vain: the node stays on this bus and listens.
    GaveUp {
        /// Where it stays.
        bus: Bus,
    },
    /// A heartbeat of the master.
    Heartbeat {
        /// Where.
        bus: Bus,
    },
    /// A SYNC on the active bus.
    Sync {
        /// Where.
        bus: Bus,
    },
    /// The device took a receive PDO.
    Pdo {
        /// Where it came.
        bus: Bus,
        /// Which, 0 is the first.
        number: u8,
    },
    /// The error state of a controller changed.
    Health {
        /// Which bus.
        bus: Bus,
        /// What it is now.
        health: Health,
    },
    /// A controller does not get on or off its bus. It tries on.
    BusStalled {
        /// Which bus.
        bus: Bus,
    },
    /// A controller went bus-off too often; it is tried again when its window ends.
    BusFailed {
        /// Which bus.
        bus: Bus,
    },
}
