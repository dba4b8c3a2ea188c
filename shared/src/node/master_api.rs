//! What a master and its application tell each other.

use crate::boot::{BootFailure, BootProgress, Difference};
use crate::emcy::Emergency;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::nmt::NmtMessage;
use crate::redundancy::{BabblingStep, RoleChange, SwitchCause};
use crate::time::Step;
use crate::types::{Address, Bus, CobId, Frame, NmtState, NodeId, Scet};

/// Events that a master reports to its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum MasterEvent {
    /// A slave reported its first state, also after it was lost, or a new one.
    SlaveState {
        /// The slave.
        node: NodeId,
        /// Bus on which it was heard.
        bus: Bus,
        /// Its state; [`NmtState::Initialising`] is its boot-up message.
        state: NmtState,
    },
    /// No heartbeat of a slave for its consumer time, on neither bus.
    SlaveLost {
        /// Slave that was lost.
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
    /// Two nodes have this Node-ID: their heartbeats report Operational and another state in turn (EMCY 8150h). The master
    /// goes on commanding the one that is Operational.
    Clash {
        /// Node-ID of both.
        node: NodeId,
    },
    /// One of the two nodes with this Node-ID was silent for ten consumer times.
    ClashOver {
        /// Node-ID of both.
        node: NodeId,
    },
    /// Another node sends the master's heartbeat, 701h (EMCY 8150h).
    SecondMaster {
        /// Bus on which it was heard.
        bus: Bus,
    },
    /// SYNCs of this master are not captured: without wires, or with broken ones, they are stamped in the interrupt (EMCY
    /// 9000h). Its slaves widen their error bounds.
    SyncUncaptured,
    /// 701h of another node was absent long enough: this collision is over.
    SecondMasterSilent {
        /// Bus on which it had been heard.
        bus: Bus,
    },
    /// A lost slave is heard again.
    SlaveReturned {
        /// Slave that returned.
        node: NodeId,
        /// Bus on which it was heard.
        bus: Bus,
    },
    /// A receive PDO took effect: its values are in the dictionary.
    Pdo {
        /// Bus on which it was received.
        bus: Bus,
        /// Number of the PDO; 0 is the first.
        number: u16,
        /// Its payload, zero behind its end: the dictionary may hold a newer one already.
        data: [u8; 8],
    },
    /// A frame with a COB-ID of [`Device::RAW_FRAMES`](crate::node::Device::RAW_FRAMES) on the active bus.
    Frame {
        /// The active bus.
        bus: Bus,
        /// The frame.
        frame: Frame,
    },
    /// A synchronous receive PDO took effect, at a SYNC of this master.
    Synchronised {
        /// Number of the PDO; 0 is the first.
        number: u16,
    },
    /// A spacecraft time arrived, and the clock follows it.
    Time(Scet),
    /// The clock was set, instead of steered: by command, for the first time, or because it was too far off.
    Step(Step),
    /// An emergency message (ECSS 6.4).
    Emergency {
        /// Node that sent it.
        node: NodeId,
        /// Bus on which it was received.
        bus: Bus,
        /// Code, error register and information of the manufacturer.
        emergency: Emergency,
    },
    /// The boot-up of an assigned slave made progress (object 2040h).
    Boot {
        /// The slave.
        node: NodeId,
        /// Step that it reached.
        progress: BootProgress,
    },
    /// The boot-up of an assigned slave failed (objects 2041h and 2042h). It is not started until it boots up again, returns
    /// or the bus changes; a slave that ran when it could not be checked goes on.
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
    /// Reset the chip: the application, or a client in 1F82h, wants the master to be reset. It goes on until then.
    ResetNode,
    /// Start the self-test (ECSS 6.7b); its result goes to object 2031h.
    SelfTest,
    /// The active bus changed.
    BusSwitched {
        /// Bus that was left.
        from: Bus,
        /// Active bus from now on.
        to: Bus,
        /// Reason of the change.
        cause: SwitchCause,
    },
    /// A SYNC went out.
    SyncSent {
        /// End of the frame.
        stamp: Stamp,
    },
    /// This master sends too much: a frame with this COB-ID was refused, with EMCY 8100h and object 2047h. Reported once until
    /// nothing was refused for a second. Above the budget of the node it is in Pre-operational for the time in its
    /// [profile](crate::profile::Profile::budget): heartbeat, NMT, SYNC, time and SDO go on.
    OverBudget {
        /// COB-ID of the frame.
        id: CobId,
    },
    /// A slave sends too much on the active bus (EMCY 8000h with its Node-ID), and the step that the master took.
    Babbling {
        /// The slave whose COB-IDs these frames have.
        node: NodeId,
        /// Step that was taken.
        step: BabblingStep,
    },
    /// Another role: active, or the standby of another master board (ECSS 8.1a).
    Role(RoleChange),
    /// Another NMT state of the master itself.
    State(NmtState),
    /// A command had to wait for a new bus to be announced, and too much waited already (counted as refused on that bus). Or
    /// this master is not active.
    Refused {
        /// For whom it was.
        node: NodeId,
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

/// Why a PDO for a slave was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The slave is lost, was never heard, or is not operational.
    NotOperational,
    /// The PDO is not valid, or the master itself is not operational.
    NotValid,
    /// Too much waits for a new bus to be announced.
    Busy,
}

/// What the application may ask of a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum MasterRequest {
    /// Make this bus the active one.
    SwitchBus(Bus),
    /// Send a module control command. A slave that is stopped or made pre-operational here is not started unasked until
    /// it is started or reset here.
    Nmt(NmtMessage),
    /// Run the boot-up process with an assigned slave again, as if it had just been heard.
    Boot(NodeId),
    /// Set the spacecraft time, as of now.
    SetTime(Scet),
    /// Become the standby of another master board, which takes over after its consumer time. If it does not, this one becomes
    /// active again after its own. Nothing happens where there is one board, or another one is active.
    StandBy,
}
