//! What the handle of a plain slave has for its application.

use super::{Handle, Outside, Platform};
use crate::node::{CanopenSlave, Counters, Device, DeviceNode};
use crate::types::NmtState;

impl<B: Platform, D: Device> Handle<B, CanopenSlave<D>> {
    /// Returns the NMT state of the slave.
    pub fn state(&self) -> NmtState {
        self.core.lock(|shared| shared.node.state())
    }

    /// Returns the counters of the frames of the bus.
    pub fn counters(&self) -> Counters {
        self.core.lock(|shared| *shared.node.counters())
    }

    /// Sends a transmit PDO (0 is the first) by its transmission type, even if its content has not changed. Refuses it,
    /// and counts that, unless the slave is Operational and the PDO is valid.
    pub fn send_pdo(&self, number: usize) {
        self.core.lend(|slave, now| slave.send_pdo(number, now));
    }

    /// Changes objects of the application as [`Handle::update`] does and sends a transmit PDO as [`Handle::send_pdo`]
    /// does, in one step: the PDO goes out once, also if its content has changed.
    pub fn send_pdo_with(&self, number: usize, update: impl FnOnce(&mut D) + Outside) {
        self.core.lend(|slave, now| {
            slave.change(now, update);
            slave.send_pdo(number, now);
        });
    }
}
