//! Events and methods between a minimal slave and its device.

use super::pdos::{MinimalPdos, Payload};
use crate::link::access::BusAccess;
use crate::link::bus_off::BusOffPolicy;
use crate::link::port::Health;
use crate::profile::Profile;
use crate::redundancy::BusCause;
use crate::redundancy::Parameters;
use crate::types::{Bus, Duration, Instant, NodeId};

/// Device of a minimal slave: its PDOs and its reactions.
pub trait MinimalDevice: 'static {
    /// PDOs of the device.
    const PDOS: MinimalPdos;
    /// `true`: the device needs SYNC even if no PDO depends on it.
    const LISTENS_TO_SYNC: bool = false;

    /// Handles receive PDO `number` (0 is the first) with `data`. Its last bit was on the bus at `at`. The data are
    /// a command, a request for telemetry, or both (ECSS 9.4.2). The returned payload is sent at once. It belongs
    /// to a transmit PDO (0 is the first) that is [sent on request](super::Trigger::Request).
    ///
    /// A frame may arrive twice: CAN repeats a frame whose sender saw an error in its last bit.
    fn on_pdo(&mut self, number: usize, data: &[u8], at: Instant) -> Option<(usize, Payload)>;

    /// Returns the payload of transmit PDO `number`, which a SYNC that ended at `at` requests. `None`: there is
    /// nothing to send.
    fn on_sync(&mut self, number: usize, at: Instant) -> Option<Payload>;
}

/// Parameters of a minimal slave, from the profile of a mission or of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Numbers {
    /// Access of the node to its two buses.
    pub access: BusAccess,
    /// Parameters of the change of the bus. With a consumer time of zero the node does not change the bus and
    /// stays on Bdefault. With a producer time of zero it sends no heartbeat.
    pub redundancy: Parameters,
    /// Policy for the recovery from bus-off.
    pub bus_off: BusOffPolicy,
    /// Lifetime of telemetry that waits for its bus.
    pub lifetime: Duration,
}

impl Numbers {
    /// Takes the parameters of node `id` from a profile. It follows the master's heartbeat. It sends its own
    /// heartbeat unless [`Profile::minimal`] lists it without one.
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

    /// Returns the same parameters for a board with one controller: one bus at a time.
    pub const fn on_one_bus(self) -> Numbers {
        Numbers { access: BusAccess::Selective, ..self }
    }

    /// Returns the same parameters without a heartbeat. Other nodes notice the slave only by its telemetry.
    pub fn without_heartbeat(self) -> Numbers {
        Numbers { redundancy: Parameters { producer: Duration::ZERO, ..self.redundancy }, ..self }
    }
}

/// Event that a minimal slave reports to its application. The device itself handles PDOs and SYNC: see [`MinimalDevice`].
///
/// "To do" in the description of an event is the work of an application that the node leaves to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MinimalEvent {
    /// The bus considered active was confirmed or changed. Nothing to do.
    ActiveBus {
        /// Bus that the slave considers active now.
        bus: Bus,
        /// Reason for the choice of the bus.
        cause: BusCause,
    },
    /// The master is missed on the active bus. The slave searches it.
    ///
    /// To do: go into a state that needs no commands, if there is one.
    MasterMissed {
        /// The active bus.
        bus: Bus,
    },
    /// The search ended without the master after Ntoggle switches. The node stays on this bus and listens.
    ///
    /// To do: go into a state that needs no commands, if there is one.
    GaveUp {
        /// Bus on which the node stays.
        bus: Bus,
    },
    /// A heartbeat of the master arrived. Nothing to do.
    Heartbeat {
        /// Bus on which it arrived.
        bus: Bus,
    },
    /// A SYNC arrived on the active bus. Nothing to do: [`MinimalDevice::on_sync`] was called.
    Sync {
        /// Bus on which it arrived.
        bus: Bus,
    },
    /// The device handled a receive PDO. Nothing to do: [`MinimalDevice::on_pdo`] was called.
    Pdo {
        /// Bus on which it arrived.
        bus: Bus,
        /// Number of the PDO; 0 is the first.
        number: u8,
    },
    /// The error state of a controller changed.
    ///
    /// To do: log it. The node recovers by itself.
    Health {
        /// Bus of the controller.
        bus: Bus,
        /// Present error state and error counters.
        health: Health,
    },
    /// A controller does not join or leave its bus: it is defective, or the bus is dominant all the time.
    ///
    /// To do: log it. The controller goes on trying.
    BusStalled {
        /// Bus of the controller.
        bus: Bus,
    },
    /// A controller went bus-off too often.
    ///
    /// To do: log it. The controller tries again when its window ends.
    BusFailed {
        /// Bus of the controller.
        bus: Bus,
    },
}
