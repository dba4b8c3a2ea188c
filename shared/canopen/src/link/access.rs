//! Access of a node to two buses.

use crate::types::{Bus, Canonical};

/// Access of a node to its two buses.
#[doc(alias("parallel access", "selective access"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusAccess {
    /// Two controllers, each on its bus all the time.
    #[default]
    Parallel,
    /// On one bus at a time. The node is silent on the other one.
    Selective,
}

impl BusAccess {
    /// Returns whether a node with this access takes part in `bus` while `active` is active.
    #[inline(always)] // a comparison
    pub fn joins(self, bus: Bus, active: Bus) -> bool {
        self == BusAccess::Parallel || bus == active
    }
}
