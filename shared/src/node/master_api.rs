//! What a master and its application tell each other.

use crate::boot::{BootFailure, BootProgress, Difference};
use crate::emcy::Emergency;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::nmt::NmtMessage;
use crate::pdo::Message;
use crate::redundancy::SwitchCause;
use crate::types::{Address, Bus, NmtState, NodeId, Scet};

/// What a master tells its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum MasterEvent {
    /// First word of a slave, also after it was lost, or another state than before.
    SlaveState {
        /// Who.
        node: NodeId,
        /// Where it was heard.
        bus: Bus,
        /// Its state; [`NmtState::Initialising`] is its boot-up message.
        state: NmtState,
    },
    /// No heartbeat of a slave for its consumer time, on neither bus.
    SlaveLost {
        /// Who.
        node: NodeId,
    },
    /// An assigned slave was heard on neither bus in the first two dwells after power-on.
    SlaveUnheard {
        /// The slave.
        node: NodeId,
    },
    /// A node sends heartbeats and its SDO server does not answer: it does not count for the choice of the bus.
    Stranger {
        /// Its Node-ID.
        node: NodeId,
    },
    /// Another node sends the master's heartbeat, 701h (EMCY 8150h).
    SecondMaster {
        /// Bus on which it was heard.
        bus: Bus,
    },
    /// 701h of another node was absent long enough: this collision is over.
    SecondMasterSilent {
        /// Bus on which it had been heard.
        bus: Bus,
    },
    /// A lost slave is heard again.
    SlaveReturned {
        /// Who.
        node: NodeId,
        /// Where.
        bus: Bus,
    },
    /// Telemetry.
    Telemetry {
        /// Of whom.
        node: NodeId,
        /// Where it came.
        bus: Bus,
        /// What.
        message: Message,
    },
    /// A Local Time PDO.
    LocalTime {
        /// Of whom.
        node: NodeId,
        /// Its time at the last SYNC.
        scet: Scet,
        /// Spacecraft time at the last SYNC, once there was one.
        reference: Option<Scet>,
    },
    /// An emergency message (ECSS 6.4).
    Emergency {
        /// Of whom.
        node: NodeId,
        /// Where it came.
        bus: Bus,
        /// What.
        emergency: Emergency,
    },
    /// The boot-up of an assigned slave went on (object 2040h).
    Boot {
        /// Of whom.
        node: NodeId,
        /// How far it is.
        progress: BootProgress,
    },
    /// The boot-up of an assigned slave failed (objects 2041h and 2042h). It is not started until it boots up again or
    /// returns; a slave that ran when it could not be checked goes on.
    BootFailed {
        /// The slave.
        node: NodeId,
        /// Error, object, expected and found value or abort code.
        failure: BootFailure,
    },
    /// A slave that was started has lost its configuration: reset without being heard, most likely. It was commanded to
    /// Pre-operational, and is configured and started again.
    ConfigurationLost {
        /// The slave.
        node: NodeId,
        /// The first value that shows it: 1020h where the slave keeps one.
        difference: Difference,
    },
    /// All mandatory slaves are configured, started and synchronised. Never reported where no slave is mandatory.
    BootCompleted,
    /// An object of the application was written by SDO.
    Written(Address),
    /// Start the self-test (ECSS 6.7b); its result goes to object 2031h.
    SelfTest,
    /// The active bus changed.
    BusSwitched {
        /// The old one.
        from: Bus,
        /// The new one.
        to: Bus,
        /// Why.
        cause: SwitchCause,
    },
    /// A SYNC went out.
    SyncSent {
        /// Its end.
        stamp: Stamp,
    },
    /// A request was refused (counted as such on the active bus).
    Refused {
        /// For whom it was.
        node: NodeId,
        /// Why.
        cause: RefusalCause,
    },
    /// The error state of a controller changed.
    Health {
        /// Which bus.
        bus: Bus,
        /// What it is now.
        health: Health,
    },
    /// A controller does not get on or off its bus: it is defective, or the bus is dominant all the time. It tries on.
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

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RefusalCause {
    /// The slave is lost, was never heard, or is not operational.
    NotOperational,
    /// Too much waits for a new bus to be announced.
    Busy,
}

/// What the application may ask of a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum MasterRequest {
    /// Send a telecommand.
    Command {
        /// To whom.
        node: NodeId,
        /// What.
        message: Message,
    },
    /// Request telemetry; the answer is [`MasterEvent::Telemetry`].
    RequestTelemetry {
        /// Of whom.
        node: NodeId,
        /// Which.
        message: Message,
    },
    /// Make this bus the active one.
    SwitchBus(Bus),
    /// Send a module control command. A slave that is stopped or made pre-operational here is not started unasked until
    /// it is started or reset here.
    Nmt(NmtMessage),
    /// Run the boot-up process with an assigned slave again, as if it had just been heard.
    Boot(NodeId),
    /// Set the spacecraft time, as of now.
    SetTime(Scet),
}
