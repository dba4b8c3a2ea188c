//! Declaration of a device: its objects, its PDOs, its names.

use core::task::Waker;

use super::{Communication, Node, Turn};
use crate::emcy::DeviceError;
use crate::heartbeat::ConsumerSlots;
use crate::od::Objects;
use crate::pdo::{PdoSet, PdoSlots};
use crate::sdo::{Client, SdoServers};
use crate::types::{AbortCode, Address, CobId, Instant, NodeId};

/// Device for a node: the objects of its application, its PDOs, and its communication profile at power-on.
///
/// `#[objects(device)]` beside the derive makes `cargo check` refuse a device that is not possible. A declaration
/// without it cannot be a device.
///
/// ```
/// use async_canopen::heartbeat::HeartbeatConsumers;
/// use async_canopen::node::{Communication, Device, Identity};
/// use async_canopen::od::Objects;
/// use async_canopen::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};
/// use async_canopen::types::NodeId;
///
/// /// A thermometer.
/// #[derive(Objects)]
/// #[objects(device)]
/// struct Thermometer {
///     /// Temperature
///     #[object(0x6000, ro, pdo)]
///     temperature: i16,
/// }
///
/// impl Device for Thermometer {
///     type Pdos = PdoObjects<4, 4>;
///     type Consumers = HeartbeatConsumers<1>;
///     const PDOS: PdoSet = PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x280)).map(Thermometer::TEMPERATURE).transmit(2)]);
///
///     fn communication(id: NodeId) -> Communication {
///         Communication { device_name: "Thermometer", ..Communication::new(id) }
///     }
/// }
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a device",
    label = "needs `impl Device for {Self}`",
    note = "add `impl Device for {Self}`, and `#[objects(device)]` beside `#[derive(Objects)]`"
)]
pub trait Device: Objects + DeviceObjects + Default + 'static {
    /// Storage of the PDOs, including those that only clients configure.
    type Pdos: PdoSlots;
    /// Entries of 1016h. In a slave the first one is for the master.
    type Consumers: ConsumerSlots;

    /// PDOs at power-on and after "reset communication".
    const PDOS: PdoSet;
    /// COB-IDs of frames that no PDO covers. A [`CanopenSlave`](super::CanopenSlave) passes these frames to its application
    /// as [`Event::Frame`](super::Event::Frame), except those of services that it has itself. A master does so, too; a slave on
    /// two buses does not.
    ///
    /// So a slave consumes the emergencies of node 5:
    ///
    /// ```
    /// use async_canopen::emcy::Emergency;
    /// use async_canopen::prelude::*;
    ///
    /// const RAW_FRAMES: &[CobId] = &[CobId::emcy(NodeId::of::<5>())]; // in `impl Device`
    ///
    /// fn on_event(event: &Event) -> Option<(NodeId, Emergency)> {
    ///     if let Event::Frame(frame) = event { Emergency::decode(frame) } else { None }
    /// }
    /// # let frame = Frame::of(RAW_FRAMES[0], [0x10, 0x81, 0x11, 0, 0, 0, 0, 0]);
    /// # assert_eq!(on_event(&Event::Frame(frame)).unwrap().0, NodeId::of::<5>());
    /// ```
    const RAW_FRAMES: &'static [CobId] = &[];

    /// Returns the communication profile at power-on and after "reset communication": names, identity, and all
    /// other values that differ from [`Communication::new`].
    fn communication(id: NodeId) -> Communication {
        Communication::new(id)
    }

    /// Returns 1016h at power-on and after "reset communication". The node fills in the first entry, that of the master, unless
    /// the [consumer time](crate::heartbeat::HeartbeatTimes::consumer) for it is zero.
    fn consumers(_id: NodeId) -> Self::Consumers {
        Self::Consumers::default()
    }

    /// Returns the PDO parameters at power-on and after "reset communication": those of [`Device::PDOS`].
    fn pdos(id: NodeId) -> Self::Pdos {
        Self::PDOS.at_power_on(id)
    }
}

/// Returns whether a transmit PDO of the device is declared as a [state](crate::pdo::Tpdo::state). The image of a device
/// without states has no code for them.
pub(super) const fn has_states<D: Device>() -> bool {
    let (tpdos, mut nth) = (D::PDOS.tpdos(), 0);
    while nth < tpdos.len() {
        if tpdos[nth].pdo().is_state() {
            return true;
        }
        nth += 1;
    }
    false
}

/// Objects that are declared as those of a device: by `#[objects(device)]`, which also has them checked.
#[diagnostic::on_unimplemented(
    message = "the declaration of `{Self}` does not say that it is a device",
    label = "add `#[objects(device)]` to the declaration of `{Self}`",
    note = "write `#[objects(device)]` beside `#[derive(Objects)]`: the compiler then checks objects and PDOs of the device"
)]
pub trait DeviceObjects {
    /// SDO servers of the device, which its declaration names. Without a word about them it has the default one alone.
    type Sdo: SdoServers;
}

/// Node with the objects of a device, which its application reads and changes.
pub trait DeviceNode: Node {
    /// Type of the device.
    type Device: Device;

    /// Returns the objects of the application.
    fn device(&self) -> &Self::Device;

    /// Changes objects of the application. Each PDO that is sent on events and has another content afterwards
    /// goes out, by its transmission type and its inhibit time.
    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut Self::Device) -> R) -> R;

    /// Writes an object, of a service or of the application, as a client of the SDO server does. The same checks
    /// apply, and the services follow the new value.
    ///
    /// # Errors
    /// The abort code that a client would receive. Then nothing has changed.
    fn write(
        &mut self,
        at: Address,
        value: &[u8],
        turn: &mut Turn<'_, Self::Event, Self::Depth>,
    ) -> Result<(), AbortCode>;

    /// Reports by an EMCY that an error of the device appeared. Its manufacturer-specific field has the source of
    /// the error, then `info`. Does nothing while the error is active already.
    fn raise(&mut self, error: DeviceError, info: [u8; 4]);

    /// Reports that an error of the device is gone. Does nothing if it is not active.
    fn clear(&mut self, error: DeviceError);
}

/// Node with an SDO client, which one transfer uses at a time. [`Handle::sdo`](crate::runner::Handle::sdo) lends it to
/// applications.
pub trait ClientNode: Node {
    /// Returns the SDO client for a transfer with the server in `node`, if no task has it. Otherwise the task is woken when it
    /// may ask again. Start the transfer at once, and [release](ClientNode::release_sdo) the client when it is over.
    fn claim_sdo(&mut self, node: NodeId, task: &Waker) -> Option<&mut Client>;

    /// Returns the SDO client that was claimed. The task is woken when the transfer needs it.
    fn claimed_sdo(&mut self, task: &Waker) -> &mut Client;

    /// Releases the SDO client. A transfer that is not over is aborted.
    fn release_sdo(&mut self);
}
