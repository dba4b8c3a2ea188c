//! NMT state machine of a slave (CiA 301 7.3.2).

use super::{Command, ErrorBehaviour};
use crate::types::{Canonical, NmtState};

/// NMT state machine of a slave.
#[doc(alias("NMT slave", "module control"))]
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NmtSlave {
    state: NmtState,
    autostart: bool,
}

/// Effect of a command or of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reaction {
    /// The state does not change.
    Unchanged,
    /// The node entered this state.
    Entered(NmtState),
    /// The node has to be reset. It sends nothing more until then.
    ResetNode,
    /// The communication starts again: call [`NmtSlave::boot`] next.
    ResetCommunication,
}

impl NmtSlave {
    /// Makes a state machine in Initialising. With `autostart` the node enters Operational by itself after its
    /// boot-up message (CiA 301 7.3.2.2.1). Otherwise it waits in Pre-operational.
    pub const fn new(autostart: bool) -> Self {
        NmtSlave { state: NmtState::Initialising, autostart }
    }

    /// Sets the state that the next [`NmtSlave::boot`] leads to.
    pub fn set_autostart(&mut self, autostart: bool) {
        self.autostart = autostart;
    }

    /// Returns the present state.
    pub const fn state(&self) -> NmtState {
        self.state
    }

    /// Lends the present state, to correct it by copies of it.
    pub const fn state_mut(&mut self) -> &mut NmtState {
        &mut self.state
    }

    /// Notes that the boot-up message is sent: leaves Initialising. Returns the state that was entered.
    pub fn boot(&mut self) -> NmtState {
        self.state = if self.autostart { NmtState::Operational } else { NmtState::PreOperational };
        self.state
    }

    /// Takes a command that addresses this node.
    pub fn on_command(&mut self, command: Command) -> Reaction {
        if self.state == NmtState::Initialising {
            return Reaction::Unchanged;
        }
        match command {
            Command::Start => self.enter(NmtState::Operational),
            Command::Stop => self.enter(NmtState::Stopped),
            Command::EnterPreOperational => self.enter(NmtState::PreOperational),
            Command::ResetNode => {
                self.state = NmtState::Initialising;
                Reaction::ResetNode
            }
            Command::ResetCommunication => {
                self.state = NmtState::Initialising;
                Reaction::ResetCommunication
            }
        }
    }

    /// Notes that the master is missed: Pre-operational from any state that communicates.
    pub fn on_master_missed(&mut self) -> Reaction {
        match self.state {
            NmtState::Initialising => Reaction::Unchanged,
            _ => self.enter(NmtState::PreOperational),
        }
    }

    /// Takes a communication error other than a missed master: missed heartbeat of another node, or bus-off.
    pub fn on_communication_error(&mut self, behaviour: ErrorBehaviour) -> Reaction {
        match (behaviour, self.state) {
            (ErrorBehaviour::PreOperational, NmtState::Operational) => self.enter(NmtState::PreOperational),
            (ErrorBehaviour::Stopped, NmtState::Operational | NmtState::PreOperational) => {
                self.enter(NmtState::Stopped)
            }
            _ => Reaction::Unchanged,
        }
    }

    fn enter(&mut self, state: NmtState) -> Reaction {
        if self.state == state {
            return Reaction::Unchanged;
        }
        self.state = state;
        Reaction::Entered(state)
    }
}
