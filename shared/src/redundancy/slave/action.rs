//! Decisions of a slave's redundancy, and the node that carries them out.

use super::Retained;
use crate::emcy::ErrorCode;
use crate::heartbeat::NodeControl;
use crate::nmt::Command;
use crate::redundancy::Parameters;
use crate::types::{Bus, NmtState, PerBus};

/// Node around the redundancy of a slave. It carries out each action before the machine goes on.
pub trait SlaveNode {
    /// Returns Node-ID, NMT state and heartbeat of the node.
    fn control(&self) -> &NodeControl;

    /// Lends them for a change.
    fn control_mut(&mut self) -> &mut NodeControl;

    /// Returns the number of frames received on each bus since power-on; wraps.
    fn received(&self) -> PerBus<u32>;

    /// Restores the communication profile of power-on with the stored parameters. Returns the redundancy parameters.
    fn restore_communication(&mut self) -> Parameters;

    /// Shows the parameters in object 2000h.
    fn show(&mut self, parameters: &Parameters);

    /// Writes Bdefault beyond power-off. Returns whether it is stored, `None` without a parameter store.
    fn note_bdefault(&mut self, bus: Bus) -> Option<bool>;

    /// Carries out an action. What it changes is due at once.
    fn act(&mut self, action: SlaveAction);
}

impl<N: SlaveNode> SlaveNode for &mut N {
    fn control(&self) -> &NodeControl {
        (**self).control()
    }

    fn control_mut(&mut self) -> &mut NodeControl {
        (**self).control_mut()
    }

    fn received(&self) -> PerBus<u32> {
        (**self).received()
    }

    fn restore_communication(&mut self) -> Parameters {
        (**self).restore_communication()
    }

    fn show(&mut self, parameters: &Parameters) {
        (**self).show(parameters);
    }

    fn note_bdefault(&mut self, bus: Bus) -> Option<bool> {
        (**self).note_bdefault(bus)
    }

    fn act(&mut self, action: SlaveAction) {
        (**self).act(action);
    }
}

/// Decision of the redundancy of a slave, which its node carries out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlaveAction {
    /// Boot up ([`NodeControl::boot`]) and send the boot-up message.
    BootUp {
        /// Bus of the message.
        bus: Bus,
    },
    /// The node entered this NMT state: its services follow.
    Entered(NmtState),
    /// Reset the chip, and send nothing until then. Repeated with each frame that is received meanwhile.
    ResetNode,
    /// Report the bus that the node considers active.
    ActiveBus {
        /// Bus that is active, or on which the node searches.
        bus: Bus,
        /// Reason for the choice of the bus.
        cause: BusCause,
        /// `true`: leave the other bus first. What is pending there is aborted, and so is a transfer.
        is_new: bool,
    },
    /// Report that the master is missed on the active bus.
    MasterMissed {
        /// The active bus.
        bus: Bus,
    },
    /// Report that the search ended without the master.
    GaveUp {
        /// Bus on which the node stays.
        bus: Bus,
    },
    /// Report an error that appeared by an EMCY.
    Raise {
        /// Error code of the EMCY.
        code: ErrorCode,
        /// First byte of the manufacturer's part; the others are zero.
        source: u8,
    },
    /// An error is gone.
    Clear {
        /// Error code of the EMCY that reported it.
        code: ErrorCode,
        /// Source of [`SlaveAction::Raise`].
        source: u8,
    },
    /// Send the emergencies that wait, whatever their inhibit time: the next state forbids them.
    SendEmergencies {
        /// Bus to send them on.
        bus: Bus,
    },
    /// Report another node with this Node-ID.
    Clash {
        /// Bus on which it was heard.
        bus: Bus,
        /// `true`: this node is silent until the other one is.
        yields: bool,
    },
    /// Report that the other node with this Node-ID is silent.
    ClashOver,
    /// Report a reset that was ignored.
    ResetIgnored {
        /// Bus on which it arrived.
        bus: Bus,
        /// "Reset node" or "reset communication".
        command: Command,
    },
    /// Write the values that outlive a reset of the chip.
    Retain(Retained),
    /// Report that a new Bdefault was to be kept beyond power-off.
    BdefaultNoted {
        /// New value of Bdefault.
        bus: Bus,
        /// `true`: it is stored.
        is_kept: bool,
    },
}

/// Reason why a slave considers a bus the active one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusCause {
    /// Power-on: the bus is Bdefault (ECSS 8.3.2a).
    PowerOn,
    /// The search continues on this bus: the master was not heard on the other one (ECSS 8.3.3e, h).
    Toggled,
    /// The master was heard on this bus: the search ended (ECSS 8.3.3g, k).
    Found,
    /// The master changed to this bus (ECSS 8.3.3g).
    Followed,
    /// A command was heard, but no heartbeat followed it: the search continues on this bus.
    Unconfirmed,
    /// The slave returned to this bus: the master was still heard here after the slave followed a heartbeat on
    /// the other one (EMCY 8150h).
    TakenBack,
    /// The application chose this bus (ECSS 8.2.3a).
    Selected,
}

/// Meaning of a received frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SlaveVerdict {
    /// Heartbeat of the master on the active bus.
    Heard,
    /// Command of the master on the active bus, or another message that was handled.
    Taken,
    /// Heartbeat of another node on the active bus. The redundancy has no use for it.
    Peer,
    /// Not for this node in this state on this bus.
    Ignored,
    /// An error in the protocol: wrong length, unknown command or state. It had no effect.
    Malformed,
}
