//! Events and requests between a master and its application.

use thiserror::Error;

use crate::boot::{BootFailure, BootProgress, Difference};
use crate::emcy::Emergency;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::nmt::NmtMessage;
use crate::pdo::{ReceivedPdo, SetRpdo};
use crate::redundancy::{BabblingStep, RoleChange, SwitchCause};
use crate::time::Step;
use crate::types::{Address, Bus, CobId, Frame, NmtState, NodeId, Scet};

/// Event that a master reports to its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum MasterEvent {
    /// A slave reported its first NMT state, also after it was lost, or a new one.
    SlaveState {
        /// Node-ID of the slave.
        node: NodeId,
        /// Bus on which it was heard.
        bus: Bus,
        /// NMT state of the slave. [`NmtState::Initialising`] is its boot-up message.
        state: NmtState,
    },
    /// The master heard no heartbeat of a slave for its consumer time on either bus.
    SlaveLost {
        /// Node-ID of the slave that was lost.
        node: NodeId,
    },
    /// An assigned slave was heard on neither bus in the first two dwells after power-on.
    SlaveUnheard {
        /// Node-ID of the slave.
        node: NodeId,
    },
    /// A node sends heartbeats, but its SDO server does not answer. It does not count for the choice of the bus.
    UnknownNode {
        /// Node-ID of the foreign node.
        node: NodeId,
    },
    /// Two nodes have this Node-ID: their heartbeats report Operational and another state in turn (EMCY 8150h).
    /// The master continues to command the node that is Operational.
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
    /// The SYNCs of this master are not captured because wires are missing or broken. They are stamped in the
    /// interrupt (EMCY 9000h). Slaves widen their error bounds.
    SyncUncaptured,
    /// The collision is over: no 701h of another node was heard for long enough.
    SecondMasterSilent {
        /// Bus on which it had been heard.
        bus: Bus,
    },
    /// A lost slave is heard again.
    SlaveReturned {
        /// Node-ID of the slave that returned.
        node: NodeId,
        /// Bus on which it was heard.
        bus: Bus,
    },
    /// A receive PDO took effect. [`ReceivedPdo::get`] returns its values, if it is the PDO that you name.
    Pdo(ReceivedPdo),
    /// A frame arrived on the active bus with a COB-ID of
    /// [`Device::RAW_FRAMES`](crate::node::Device::RAW_FRAMES).
    Frame {
        /// The active bus.
        bus: Bus,
        /// Received frame, with its data.
        frame: Frame,
    },
    /// A synchronous receive PDO took effect, at a SYNC of this master. [`SetRpdo::is`] compares it with the PDO that you name.
    Synchronised(SetRpdo),
    /// A spacecraft time arrived, and the clock follows it.
    Time(Scet),
    /// The clock was set instead of steered: by command, for the first time, or because it was too far off.
    Step(Step),
    /// An emergency message arrived (ECSS 6.4).
    Emergency {
        /// Node that sent it.
        node: NodeId,
        /// Bus on which it was received.
        bus: Bus,
        /// Code, error register and information of the manufacturer.
        emergency: Emergency,
    },
    /// The active errors of a slave are others than the master knew: it read the register and the history of the slave after
    /// a change of the bus, a takeover, or a boot-up message (object 2048h).
    ErrorsRead {
        /// Node-ID of the slave.
        node: NodeId,
    },
    /// An active error of a slave has no place in object 2048h: 64 are there.
    ErrorNotKept {
        /// Node-ID of the slave.
        node: NodeId,
    },
    /// A frame was not sent, and none replaces it: a command, or another frame of the application, or a transmit PDO that
    /// is sent on events alone, without an event timer, and is no [state](crate::pdo::Tpdo::state).
    NotSent {
        /// Bus for which it was meant.
        bus: Bus,
        /// COB-ID of the frame.
        id: CobId,
        /// Payload of the frame, zero above its length.
        data: [u8; 8],
    },
    /// The boot-up of an assigned slave made progress (object 2040h).
    Boot {
        /// Node-ID of the slave.
        node: NodeId,
        /// Step that it reached.
        progress: BootProgress,
    },
    /// The boot-up of an assigned slave failed (objects 2041h and 2042h). The master does not start it until it
    /// boots up again, returns, or the active bus changes. A slave that was running and could not be checked
    /// continues.
    BootFailed {
        /// Node-ID of the slave.
        node: NodeId,
        /// Error and cause: the object, and the values or the abort code.
        failure: BootFailure,
    },
    /// A slave that was started lost its configuration. Most likely it was reset and not heard. The master
    /// commanded it to Pre-operational, and configures and starts it again.
    ConfigurationLost {
        /// Node-ID of the slave.
        node: NodeId,
        /// First value that differs: 1020h if the slave keeps one.
        difference: Difference,
    },
    /// All mandatory slaves are configured, started and synchronised. Never reported if no slave is mandatory.
    BootCompleted,
    /// A client wrote an object of the application by SDO.
    Written(Address),
    /// Reset the chip: the application, or a client in 1F82h, requested a reset of the master. The master
    /// continues until then.
    ResetNode,
    /// Start the self-test (ECSS 6.7b), and write its result to object 2031h.
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
    /// No slave was heard on either bus in Ntoggle changes of the bus. The master stays on this bus until it hears
    /// one, or until a command changes the bus.
    GaveUp {
        /// Bus on which it stays.
        bus: Bus,
    },
    /// A SYNC went out.
    SyncSent {
        /// End of the frame.
        stamp: Stamp,
    },
    /// This master sends too many frames: a frame with this COB-ID was refused, with EMCY 8100h and object 2047h.
    /// Reported once until no frame was refused for a second. Above the budget of the node, the master is in
    /// Pre-operational for the time in its [profile](crate::profile::Profile::budget). Heartbeat, NMT, SYNC, time
    /// and SDO continue.
    OverBudget {
        /// COB-ID of the refused frame.
        id: CobId,
    },
    /// A slave sends too many frames on the active bus (EMCY 8000h with its Node-ID), and the master took this
    /// step.
    Babbling {
        /// Node-ID of the slave: its COB-IDs are those of the frames.
        node: NodeId,
        /// Step that the master took.
        step: BabblingStep,
    },
    /// The role of this board changed: active, or standby of another master board (ECSS 8.1a).
    Role(RoleChange),
    /// The NMT state of the master itself changed.
    State(NmtState),
    /// A command was refused: this master is not active, or too many commands wait for the announcement of a new
    /// bus. In the second case the command is counted as refused on that bus.
    Refused {
        /// Node-ID that the command was for.
        node: NodeId,
    },
    /// The error state of a controller changed.
    Health {
        /// Bus of the controller.
        bus: Bus,
        /// Present error state and error counters.
        health: Health,
    },
    /// A controller does not join or leave its bus: it is defective, or the bus is dominant all the time. It goes
    /// on trying.
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

/// Reason why a PDO for a slave was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The slave is lost, was never heard, or is not Operational.
    #[error("the slave is lost, was never heard, or is not Operational")]
    NotOperational,
    /// The PDO is not valid, or the master itself is not Operational.
    #[error("the PDO is not valid, or the master is not Operational")]
    NotValid,
    /// Too many commands wait for the announcement of a new bus.
    #[error("too many commands wait for the announcement of a new bus: try again")]
    Busy,
}

/// Request to a master. An application makes it by a method of [`MasterHandle`](crate::runner::MasterHandle).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum MasterRequest {
    /// Make this bus the active one.
    SwitchBus(Bus),
    /// Send a module control command. A slave that is stopped or made Pre-operational by it is not started again
    /// before the application starts or resets it.
    Nmt(NmtMessage),
    /// Run the boot-up process with an assigned slave again, as if it had just been heard.
    Boot(NodeId),
    /// Set the spacecraft time, as of now.
    SetTime(Scet),
    /// Become the standby of another master board, which takes over after its consumer time. If it does not, this
    /// board becomes active again after its own consumer time. Does nothing with one master board, or if another
    /// one is active.
    StandBy,
}
