//! What the handle of a slave has beyond that of a CANopen node.

use super::extend::WholeNode;
use super::{Handle, Outside, Platform};
use crate::node::{DeviceNode, ParallelAccess, SelfTest, Slave, SpacecraftDevice, Status};
use crate::pdo::Pdo;
use crate::types::Bus;

/// What the handle of a slave has beyond that of a CANopen node.
pub trait SlaveHandle {
    /// Type of the device.
    type Device: SpacecraftDevice;

    /// Returns the state of the slave at the present instant.
    fn status(&self) -> Status;

    /// Chooses the bus of a slave with selective access (ECSS 8.2.3a). The slave enters Pre-operational and searches
    /// the master, beginning on `bus` with Ctoggle zero.
    /// [`SlaveEvent::ActiveBus`](crate::node::SlaveEvent::ActiveBus) reports the choice.
    ///
    /// # Errors
    /// [`ParallelAccess`]: the master chooses the bus of a slave with parallel access.
    fn select_bus(&self, bus: Bus) -> Result<(), ParallelAccess>;

    /// Resets the counters of both buses to zero.
    fn reset_counters(&self);

    /// Puts the result of a self-test into object 2031h (ECSS 6.7b).
    fn report_self_test(&self, result: SelfTest);

    /// Sends a transmit PDO of the device by its transmission type, even if its content has not changed. Refuses it,
    /// and counts that on the active bus, unless the slave is Operational and the PDO is in the set of the device and valid.
    fn send<T>(&self, pdo: Pdo<Self::Device, T>);

    /// Changes objects of the application as [`Handle::update`] does and sends a transmit PDO as
    /// [`send`](SlaveHandle::send) does, in one step: the PDO goes out once, also if its content has changed.
    fn send_with<T>(&self, pdo: Pdo<Self::Device, T>, update: impl FnOnce(&mut Self::Device) + Outside);
}

impl<B: Platform, D: SpacecraftDevice> SlaveHandle for Handle<B, Slave<D>> {
    type Device = D;

    fn status(&self) -> Status {
        let now = self.now();
        self.inspect(|slave| slave.status(now))
    }

    fn select_bus(&self, bus: Bus) -> Result<(), ParallelAccess> {
        self.with(|slave, _| slave.select_bus(bus))
    }

    fn reset_counters(&self) {
        self.with(|slave, _| slave.reset_counters());
    }

    fn report_self_test(&self, result: SelfTest) {
        self.with(|slave, now| slave.report_self_test(result, now));
    }

    fn send<T>(&self, pdo: Pdo<D, T>) {
        let number = D::PDOS.number_of(pdo);
        self.with(|slave, now| slave.send_pdo(number, now));
    }

    fn send_with<T>(&self, pdo: Pdo<D, T>, update: impl FnOnce(&mut D) + Outside) {
        let number = D::PDOS.number_of(pdo);
        self.with(|slave, now| {
            slave.change(now, update);
            slave.send_pdo(number, now);
        });
    }
}
