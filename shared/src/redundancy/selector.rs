//! The slave's side: follow the master's heartbeat, search for it when it is missed (ECSS 8.3.3).

use super::Parameters;
use crate::heartbeat::Consumer;
use crate::link::Bus;
use crate::time::Instant;

/// Decides which bus a slave considers active.
///
/// A slave with selective access hears the selected bus only; one with parallel access tells of master messages on
/// both. The selector makes no difference between them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Selector {
    parameters: Parameters,
    selected: Bus,
    phase: Phase,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Phase {
    /// The selected bus is the active one.
    Following { master: Consumer },
    /// Bus selection process; on the selected bus since then.
    Searching { since: Instant },
    /// Switching is disabled, or Ntoggle switches were in vain: stay and listen.
    Listening,
}

/// What the master said: "NMT message" of ECSS 8.3.3g is any of these, well-formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MasterMessage {
    /// Its heartbeat or its boot-up message.
    Heartbeat,
    /// A module control command, to whomever.
    Command,
}

/// What the selector decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Selection {
    /// The master is missed on the active bus: enter Pre-operational.
    Missed {
        /// Where it was heard last.
        bus: Bus,
    },
    /// The node changes to the other bus, in Pre-operational, and sends its heartbeat there.
    Toggled {
        /// The bus selected now.
        to: Bus,
    },
    /// Nothing heard on either bus: the node stays where it is, listening.
    GaveUp {
        /// Where it stays.
        bus: Bus,
    },
    /// The search ended: the selected bus is the active one.
    Found {
        /// Which.
        bus: Bus,
        /// Whether the node had selected the other one until now.
        moved: bool,
    },
    /// The master went to the other bus before it was missed: the node follows at once.
    Followed {
        /// The bus active now.
        to: Bus,
    },
}

impl Selector {
    /// On the default bus, Ctoggle zero (ECSS 8.3.2a). Idle until [`Selector::start`].
    pub const fn new(parameters: Parameters) -> Self {
        Selector {
            selected: parameters.bdefault,
            parameters: Parameters { ctoggle: 0, ..parameters },
            phase: Phase::Listening,
        }
    }

    /// The bus that the node considers active, or on which it searches.
    pub const fn selected(&self) -> Bus {
        self.selected
    }

    /// The parameters, Bdefault and Ctoggle as they are now.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// New parameters. What runs goes on with them; a search ends when they disable switching.
    pub fn configure(&mut self, parameters: Parameters) {
        self.parameters = parameters;
        if matches!(self.phase, Phase::Searching { .. }) && !parameters.toggling_enabled() {
            self.phase = Phase::Listening;
        }
    }

    /// Pre-operational was entered after power-on or reset communication: search, beginning with the bus selected now
    /// (ECSS 8.3.2b). Reset communication keeps the bus; only power-on selects Bdefault.
    pub fn start(&mut self, now: Instant) {
        self.search(now);
    }

    /// A message of the master on `bus` ended at `at`.
    pub fn on_master(&mut self, bus: Bus, message: MasterMessage, at: Instant) -> Option<Selection> {
        let moved = bus != self.selected;
        let found = match &mut self.phase {
            Phase::Following { master } if !moved => {
                if message == MasterMessage::Heartbeat {
                    master.on_heartbeat(at);
                }
                return None;
            }
            // Frames of two buses may be told out of order.
            Phase::Following { master: Consumer::Armed { last } } if at < *last => return None,
            Phase::Following { .. } => Selection::Followed { to: bus },
            Phase::Searching { .. } | Phase::Listening => Selection::Found { bus, moved },
        };
        // ECSS 8.3.3k, l; not on the late branch of Figure 8-3, after giving up.
        if self.phase != Phase::Listening {
            self.parameters.bdefault = bus;
        }
        self.parameters.ctoggle = 0;
        self.selected = bus;
        self.phase = Phase::Following { master: Consumer::Armed { last: at } };
        Some(found)
    }

    /// One decision that is due at `now`; call until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<Selection> {
        let parameters = self.parameters;
        match &mut self.phase {
            Phase::Following { master } => {
                let last = master.poll(now, parameters.consumer)?;
                // The toggling time counts from the last heartbeat, not from the miss (ECSS 8.3.3e, Figure 8-2).
                self.search(last);
                Some(Selection::Missed { bus: self.selected })
            }
            Phase::Searching { since } => {
                let end = *since + parameters.toggling_time();
                if now < end {
                    return None;
                }
                if parameters.ctoggle >= parameters.ntoggle {
                    self.phase = Phase::Listening;
                    return Some(Selection::GaveUp { bus: self.selected });
                }
                // A toggling time that was shortened meanwhile may have passed several times: each bus is listened to.
                *since = if now < end + parameters.toggling_time() { end } else { now };
                self.parameters.ctoggle = parameters.ctoggle.saturating_add(1);
                self.selected = self.selected.other();
                Some(Selection::Toggled { to: self.selected })
            }
            Phase::Listening => None,
        }
    }

    /// When [`Selector::poll`] has something to decide.
    pub fn deadline(&self) -> Option<Instant> {
        match self.phase {
            Phase::Following { master } => master.deadline(self.parameters.consumer),
            Phase::Searching { since } => Some(since + self.parameters.toggling_time()),
            Phase::Listening => None,
        }
    }

    fn search(&mut self, since: Instant) {
        self.phase =
            if self.parameters.toggling_enabled() { Phase::Searching { since } } else { Phase::Listening };
    }
}
