//! Events and requests between a master and its application.

use thiserror::Error;

use super::events::role_events;
use crate::boot::{BootFailure, BootProgress, Difference};
use crate::emcy::Emergency;
use crate::link::Stamp;
use crate::nmt::NmtMessage;
use crate::redundancy::{BabblingStep, RoleChange, SwitchCause};
use crate::types::{Bus, Frame, NmtState, NodeId, Scet};

role_events! {
    /// Event that a master reports to its application.
    MasterEvent {
        /// A slave reported its first NMT state, also after it was lost, or a new one.
        ///
        /// To do: begin the work with the slave in Operational, and stop it in other states.
        SlaveState {
            /// Node-ID of the slave.
            node: NodeId,
            /// Bus on which it was heard.
            bus: Bus,
            /// NMT state of the slave. [`NmtState::Initialising`] is its boot-up message.
            state: NmtState,
        },
        /// The master heard no heartbeat of a slave for its consumer time on either bus.
        ///
        /// To do: stop the work with the slave. The master starts it again when it returns.
        SlaveLost {
            /// Node-ID of the slave that was lost.
            node: NodeId,
        },
        /// A lost slave is heard again. Nothing to do: [`MasterEvent::SlaveState`] follows.
        SlaveReturned {
            /// Node-ID of the slave that returned.
            node: NodeId,
            /// Bus on which it was heard.
            bus: Bus,
        },
        /// An assigned slave was heard on neither bus in the first two dwells after power-on.
        ///
        /// To do: log it, and do without the slave. The master starts it when it is heard.
        SlaveUnheard {
            /// Node-ID of the slave.
            node: NodeId,
        },
        /// A node sends heartbeats, but its SDO server does not answer. It does not count for the choice of the bus.
        ///
        /// To do: log it. The network has a node that the mission does not know.
        UnknownNode {
            /// Node-ID of the foreign node.
            node: NodeId,
        },
        /// Two nodes have this Node-ID: their heartbeats report Operational and another state in turn (EMCY 8150h).
        /// The master continues to command the node that is Operational.
        ///
        /// To do: log it. One of the two boards has wrong straps or a wrong stored Node-ID.
        Clash {
            /// Node-ID of both.
            node: NodeId,
        },
        /// One of the two nodes with this Node-ID was silent for ten consumer times. Nothing to do.
        ClashOver {
            /// Node-ID of both.
            node: NodeId,
        },
        /// Another node sends the master's heartbeat, 701h (EMCY 8150h).
        ///
        /// To do: switch one of the two masters off, unless they are the two boards of a profile.
        SecondMaster {
            /// Bus on which it was heard.
            bus: Bus,
        },
        /// The collision is over: no 701h of another node was heard for long enough. Nothing to do.
        SecondMasterSilent {
            /// Bus on which it had been heard.
            bus: Bus,
        },
        /// The SYNCs of this master are not captured because wires are missing or broken. They are stamped in the
        /// interrupt (EMCY 9000h). Slaves widen their error bounds.
        ///
        /// To do: log it. The wires of the board are in `docs/wiring.md`.
        SyncUncaptured,
        /// A frame arrived on the active bus with a COB-ID of
        /// [`Device::RAW_FRAMES`](crate::node::Device::RAW_FRAMES).
        ///
        /// To do: decode it.
        Frame {
            /// The active bus.
            bus: Bus,
            /// Received frame, with its data.
            frame: Frame,
        },
        /// An emergency message arrived (ECSS 6.4).
        ///
        /// To do: react by its code, such as with a reset of the node, or log it.
        Emergency {
            /// Node that sent it.
            node: NodeId,
            /// Bus on which it was received.
            bus: Bus,
            /// Code, error register and information of the manufacturer.
            emergency: Emergency,
        },
        /// The active errors of a slave are others than the master knew: it read the register and the history of the
        /// slave after a change of the bus, a takeover, or a boot-up message (object 2048h).
        ///
        /// To do: read them with [`MasterHandle::active_errors`](crate::runner::MasterHandle::active_errors).
        ErrorsRead {
            /// Node-ID of the slave.
            node: NodeId,
        },
        /// An active error of a slave has no place in object 2048h: 64 are there.
        ///
        /// To do: log it. The slave has the error in its 1003h.
        ErrorNotKept {
            /// Node-ID of the slave.
            node: NodeId,
        },
        /// The boot-up of an assigned slave made progress (object 2040h). Nothing to do.
        Boot {
            /// Node-ID of the slave.
            node: NodeId,
            /// Step that it reached.
            progress: BootProgress,
        },
        /// The boot-up of an assigned slave failed (objects 2041h and 2042h). The master does not start it until it
        /// boots up again, returns, or the active bus changes. A slave that was running and could not be checked
        /// continues.
        ///
        /// To do: log it. The failure names the object that differs. After the cause is removed, request the boot-up
        /// again ([`MasterHandle::boot`](crate::runner::MasterHandle::boot)).
        BootFailed {
            /// Node-ID of the slave.
            node: NodeId,
            /// Error and cause: the object, and the values or the abort code.
            failure: BootFailure,
        },
        /// A slave that was started lost its configuration. Most likely it was reset and not heard. The master
        /// commanded it to Pre-operational, and configures and starts it again. Nothing to do.
        ConfigurationLost {
            /// Node-ID of the slave.
            node: NodeId,
            /// First value that differs: 1020h if the slave keeps one.
            difference: Difference,
        },
        /// All mandatory slaves are configured, started and synchronised. Never reported if no slave is mandatory.
        ///
        /// To do: begin the work that needs all of them.
        BootCompleted,
        /// The active bus changed.
        ///
        /// To do: repeat SDO transfers that ended with
        /// [`Error::BusChanged`](crate::sdo::Error::BusChanged).
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
        ///
        /// To do: log it. Command the other bus if the failure of this one is known.
        GaveUp {
            /// Bus on which it stays.
            bus: Bus,
        },
        /// A SYNC was sent.
        ///
        /// To do: sample, if the application samples at SYNC.
        SyncSent {
            /// End of the frame.
            stamp: Stamp,
        },
        /// A slave sends too many frames on the active bus (EMCY 8000h with its Node-ID), and the master took this
        /// step.
        ///
        /// To do: log it. Switch the slave off if no step helps.
        Babbling {
            /// Node-ID of the slave: its COB-IDs are those of the frames.
            node: NodeId,
            /// Step that the master took.
            step: BabblingStep,
        },
        /// The role of this board changed: active, or standby of another master board (ECSS 8.1a).
        ///
        /// To do: send commands as the active master only.
        Role(RoleChange),
        /// A command was refused: this master is not active, or too many commands wait for the announcement of a new
        /// bus. In the second case the command is counted as refused on that bus.
        ///
        /// To do: send it again after the announcement, if it is still useful.
        Refused {
            /// Node-ID that the command was for.
            node: NodeId,
        },
    }
}

/// Reason why a PDO for a slave was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refusal {
    /// The slave is lost, was never heard, or is not Operational.
    #[error("the slave is lost, was never heard, or is not Operational: wait until it is")]
    NotOperational,
    /// The PDO is not valid, or the master itself is not Operational.
    #[error("the PDO is not valid, or the master is not Operational: enable the PDO, or wait until it is")]
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
