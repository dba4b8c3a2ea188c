//! Decisions of a slave's redundancy, which its node carries out.

use super::Retained;
use crate::emcy::ErrorCode;
use crate::heartbeat::machine::NodeControl;
use crate::nmt::Command;
use crate::types::{Bus, Instant, PerBus};

/// Most actions of one step: ignored resets are forgotten (3), the bus changes (5), and a reset is obeyed (2).
pub(super) const MOST: usize = 10;

/// One step of the redundancy of a slave: what it looks at, and what it decides.
#[derive(Debug)]
pub struct SlaveStep<'a> {
    /// Present instant.
    pub(super) now: Instant,
    /// Node-ID, NMT state and heartbeat of the node.
    pub(super) control: &'a NodeControl,
    /// Number of frames received on each bus since power-on; wraps.
    pub(super) received: PerBus<u32>,
    actions: &'a mut SlaveActions,
}

/// Decisions of a step, in the order in which the node carries them out.
pub type SlaveActions = heapless::Vec<SlaveAction, MOST>;

impl<'a> SlaveStep<'a> {
    /// Begins a step at `now`. `received`: number of frames received on each bus since power-on; wraps. What the node has to
    /// carry out is added to `actions`.
    pub const fn new(
        now: Instant,
        control: &'a NodeControl,
        received: PerBus<u32>,
        actions: &'a mut SlaveActions,
    ) -> Self {
        SlaveStep { now, control, received, actions }
    }

    #[inline(never)] // row `size.pyboard-v11.slave.flash`: 88 bytes
    pub(super) fn act(&mut self, action: SlaveAction) {
        let is_placed = self.actions.push(action).is_ok();
        debug_assert!(is_placed, "a step has {MOST} actions at most");
    }
}

/// Decision of the redundancy of a slave, which its node carries out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlaveAction {
    /// Obey a command of the master ([`NodeControl::on_command`]). After "reset communication" call
    /// [`SlaveRedundancy::boot`](super::SlaveRedundancy::boot).
    Obey(Command),
    /// Wait for the reset of the chip. Repeated with each frame that is received meanwhile.
    WaitForReset,
    /// Leave Operational: the master is missed, or the node is silenced ([`NodeControl::on_master_missed`]).
    EnterPreOperational,
    /// Send a heartbeat at once ([`NodeControl::announce`]).
    Announce,
    /// Show the parameters in object 2000h ([`SlaveRedundancy::parameters`](super::SlaveRedundancy::parameters)).
    ShowParameters,
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
    /// Send the emergencies that wait, whatever their inhibit time, and stop: another node has this Node-ID
    /// ([`NodeControl::fall_silent`]).
    FallSilent {
        /// Bus of the emergencies.
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
    /// Write the values that outlive a reset of the chip ([`Retained::encode`]).
    Retain(Retained),
    /// Keep Bdefault beyond power-off. If the node has a parameter store, report whether it was kept, and call
    /// [`SlaveRedundancy::on_noted`](super::SlaveRedundancy::on_noted).
    NoteBdefault {
        /// New value of Bdefault.
        bus: Bus,
        /// `false`: enough was written since power-on, so it is not kept.
        may_write: bool,
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
