//! What the handle of a minimal slave has for its application.

use super::extend::WholeNode;
use super::{Handle, Outside, Platform};
use crate::link::port::Health;
use crate::node::Counters;
use crate::node::minimal::{MinimalDevice, MinimalSlave};
use crate::types::{Bus, PerBus};

/// What the handle of a minimal slave has for its application. A minimal slave has no objects: its device is lent for
/// reading.
pub trait MinimalHandle {
    /// Type of the device.
    type Device: MinimalDevice;

    /// Lends the device to `read` and returns its result. Wakes no task. `read` cannot use a handle: see [`Outside`].
    fn read<R>(&self, read: impl FnOnce(&Self::Device) -> R + Outside) -> R;

    /// Returns the bus that the slave considers active, or on which it searches.
    fn active(&self) -> Bus;

    /// Returns the counters of the frames of each bus.
    fn counters(&self) -> PerBus<Counters>;

    /// Returns error state and counters of each controller (ECSS 5.6.2b, c).
    fn health(&self) -> PerBus<Health>;
}

impl<B: Platform, D: MinimalDevice> MinimalHandle for Handle<B, MinimalSlave<D>> {
    type Device = D;

    fn read<R>(&self, read: impl FnOnce(&D) -> R + Outside) -> R {
        self.inspect(|slave| read(slave.device()))
    }

    fn active(&self) -> Bus {
        self.inspect(MinimalSlave::active)
    }

    fn counters(&self) -> PerBus<Counters> {
        self.inspect(|slave| *slave.counters())
    }

    fn health(&self) -> PerBus<Health> {
        self.inspect(|slave| *slave.health())
    }
}
