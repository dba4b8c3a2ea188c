//! What the handle of a minimal slave has for its application.

use easy_ext::ext;

use super::extend::WholeNode;
use super::{Handle, Outside, Platform};
use crate::link::port::Health;
use crate::node::Counters;
use crate::node::minimal::{MinimalDevice, MinimalSlave};
use crate::types::{Bus, PerBus};

/// What the handle of a minimal slave has for its application. A minimal slave has no objects: its device is lent for
/// reading.
#[ext(MinimalHandle)]
impl<B: Platform, D: MinimalDevice> Handle<B, MinimalSlave<D>> {
    /// Lends the device to `read` and returns its result. Wakes no task. `read` cannot use a handle: see [`Outside`].
    pub fn read<R>(&self, read: impl FnOnce(&D) -> R + Outside) -> R {
        self.inspect(|slave| read(slave.device()))
    }

    /// Returns the bus that the slave considers active, or on which it searches.
    pub fn active(&self) -> Bus {
        self.inspect(MinimalSlave::active)
    }

    /// Returns the counters of the frames of each bus.
    pub fn counters(&self) -> PerBus<Counters> {
        self.inspect(|slave| *slave.counters())
    }

    /// Returns error state and counters of each controller (ECSS 5.6.2b, c).
    pub fn health(&self) -> PerBus<Health> {
        self.inspect(|slave| *slave.health())
    }
}
