//! What the handle of a slave has beyond that of a CANopen node.

use easy_ext::ext;

use super::extend::WholeNode;
use super::{Handle, Outside, Platform};
use crate::node::{DeviceNode, ParallelAccess, SelfTest, Slave, SpacecraftDevice, Status};
use crate::pdo::Pdo;
use crate::types::Bus;

/// What the handle of a slave has beyond that of a CANopen node.
#[ext(SlaveHandle)]
impl<B: Platform, D: SpacecraftDevice> Handle<B, Slave<D>> {
    /// Returns the state of the slave at the present instant.
    pub fn status(&self) -> Status {
        let now = self.now();
        self.inspect(|slave| slave.status(now))
    }

    /// Chooses the bus of a slave with selective access (ECSS 8.2.3a). The slave enters Pre-operational and searches
    /// the master, beginning on `bus` with Ctoggle zero.
    /// [`SlaveEvent::ActiveBus`](crate::node::SlaveEvent::ActiveBus) reports the choice.
    ///
    /// # Errors
    /// [`ParallelAccess`]: the master chooses the bus of a slave with parallel access.
    pub fn select_bus(&self, bus: Bus) -> Result<(), ParallelAccess> {
        self.with(|slave, _| slave.select_bus(bus))
    }

    /// Resets the counters of both buses to zero.
    pub fn reset_counters(&self) {
        self.with(|slave, _| slave.reset_counters());
    }

    /// Puts the result of a self-test into object 2031h (ECSS 6.7b).
    pub fn report_self_test(&self, result: SelfTest) {
        self.with(|slave, now| slave.report_self_test(result, now));
    }

    /// Sends a transmit PDO of the device by its transmission type, even if its content has not changed. Refuses it,
    /// and counts that on the active bus, unless the slave is Operational and the PDO is in the set of the device and valid.
    pub fn send<T>(&self, pdo: Pdo<D, T>) {
        let number = D::PDOS.number_of(pdo);
        self.with(|slave, now| slave.send_pdo(number, now));
    }

    /// Changes objects of the application as [`Handle::update`] does and sends a transmit PDO as
    /// [`send`](SlaveHandle::send) does, in one step: the PDO goes out once, also if its content has changed.
    pub fn send_with<T>(&self, pdo: Pdo<D, T>, update: impl FnOnce(&mut D) + Outside) {
        let number = D::PDOS.number_of(pdo);
        self.with(|slave, now| {
            slave.change(now, update);
            slave.send_pdo(number, now);
        });
    }
}
