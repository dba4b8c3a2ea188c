//! Events and methods between a minimal slave and its device.

use super::pdos::{MinimalPdos, Payload};
use crate::link::port::Health;
use crate::redundancy::BusCause;
use crate::types::{Bus, Instant};

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

/// Event that a minimal slave reports to its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MinimalEvent {
    /// The bus considered active was confirmed or changed.
    ActiveBus {
        /// Bus that the slave considers active now.
        bus: Bus,
        /// Reason for the choice of the bus.
        cause: BusCause,
    },
    /// The master is missed on the active bus.
    MasterMissed {
        /// The active bus.
        bus: Bus,
    },
    /// The search ended without the master after Ntoggle switches. The node stays on this bus and listens.
    GaveUp {
        /// Bus on which the node stays.
        bus: Bus,
    },
    /// A heartbeat of the master arrived.
    Heartbeat {
        /// Bus on which it arrived.
        bus: Bus,
    },
    /// A SYNC arrived on the active bus.
    Sync {
        /// Bus on which it arrived.
        bus: Bus,
    },
    /// The device handled a receive PDO.
    Pdo {
        /// Bus on which it arrived.
        bus: Bus,
        /// Number of the PDO; 0 is the first.
        number: u8,
    },
    /// The error state of a controller changed.
    Health {
        /// Bus of the controller.
        bus: Bus,
        /// Present error state and error counters.
        health: Health,
    },
    /// A controller does not join or leave its bus. It goes on trying.
    BusStalled {
        /// Bus of the controller.
        bus: Bus,
    },
    /// A controller went bus-off too often. It tries again when its window ends.
    BusFailed {
        /// Bus of the controller.
        bus: Bus,
    },
}
