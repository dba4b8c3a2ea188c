//! What the handle of a plain slave has for its application.

use super::{Handle, Outside, Platform};
use crate::node::{CanopenSlave, Counters, Device, DeviceNode};
use crate::pdo::Pdo;
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

    /// Sends a transmit PDO of the device by its transmission type, even if its content has not changed. Refuses it,
    /// and counts that, unless the slave is Operational and the PDO is in the set of the device and valid.
    pub fn send<T>(&self, pdo: Pdo<D, T>) {
        let number = D::PDOS.number_of(pdo);
        self.core.lend(|slave, now| slave.send_pdo(number, now));
    }

    /// Changes objects of the application as [`Handle::update`] does and sends a transmit PDO as [`Handle::send`]
    /// does, in one step: the PDO goes out once, also if its content has changed.
    pub fn send_with<T>(&self, pdo: Pdo<D, T>, update: impl FnOnce(&mut D) + Outside) {
        let number = D::PDOS.number_of(pdo);
        self.core.lend(|slave, now| {
            slave.change(now, update);
            slave.send_pdo(number, now);
        });
    }
}
