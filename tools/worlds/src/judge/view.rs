//! A network at one instant.

use ecss_can::link::access::BusAccess;
use ecss_can::redundancy::Parameters;
use ecss_can::types::{Bus, NmtState, PerBus};

/// Most masters of a view.
pub const MASTERS: usize = 2;

/// Nodes of a spacecraft at one instant, and which of them a bus joins.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Master boards: one, or two of which one is the standby. Rules identify a master by its index.
    pub masters: &'a [Master],
    /// Slaves. Rules identify a slave by its index.
    pub slaves: &'a [Slave],
    /// Buses on which each of two masters receives the other one's frames, if both have power.
    pub joins_masters: PerBus<bool>,
}

/// A master board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Master {
    /// The board has power.
    pub is_powered: bool,
    /// Bus that it manages; `None`: it is not active.
    pub bus: Option<Bus>,
    /// It changed the bus since the view before.
    pub has_switched: bool,
    /// It became active, or the standby, since the view before.
    pub has_changed_role: bool,
}

/// A slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slave {
    /// The node has power.
    pub is_powered: bool,
    /// NMT state; Initialising if unknown.
    pub state: NmtState,
    /// Bus that it considers active; `None` if unknown.
    pub bus: Option<Bus>,
    /// How it accesses its buses.
    pub access: BusAccess,
    /// It ended its search without a master, and listens on its bus (ECSS 8.3.3j).
    pub has_given_up: bool,
    /// Object 2000h; `None` if unknown.
    pub parameters: Option<Parameters>,
    /// For each master, buses whose cable joins the two. Power and controllers do not count.
    pub wired: [PerBus<bool>; MASTERS],
}

/// A slave with power, parallel access, and no cable.
impl Default for Slave {
    fn default() -> Self {
        Slave {
            is_powered: true,
            state: NmtState::Initialising,
            bus: None,
            access: BusAccess::Parallel,
            has_given_up: false,
            parameters: None,
            wired: [PerBus::default(); MASTERS],
        }
    }
}

impl Slave {
    /// Returns whether its controller takes part in a bus.
    pub fn listens(&self, bus: Bus) -> bool {
        self.access == BusAccess::Parallel || self.bus == Some(bus)
    }
}

impl View<'_> {
    /// Masters with power.
    pub fn powered(&self) -> impl Iterator<Item = usize> {
        (0..self.masters.len()).filter(|master| self.masters[*master].is_powered)
    }

    /// Masters with power that are active, and the bus that each manages.
    pub fn active(&self) -> impl Iterator<Item = (usize, Bus)> {
        self.powered().filter_map(|master| Some((master, self.masters[master].bus?)))
    }

    pub(crate) fn all_slaves(&self) -> core::ops::Range<usize> {
        0..self.slaves.len()
    }
}

/// Shared code of the tests of the rules.
#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub const NEITHER: PerBus<bool> = PerBus { nominal: false, redundant: false };
    pub const NOMINAL: PerBus<bool> = PerBus { nominal: true, redundant: false };
    pub const REDUNDANT: PerBus<bool> = PerBus { nominal: false, redundant: true };
    pub const BOTH: PerBus<bool> = PerBus { nominal: true, redundant: true };
    pub const MASTER: Master =
        Master { is_powered: true, bus: Some(Bus::Nominal), has_switched: false, has_changed_role: false };

    pub fn view<'a>(masters: &'a [Master], slaves: &'a [Slave]) -> View<'a> {
        View { masters, slaves, joins_masters: NEITHER }
    }
}
