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
