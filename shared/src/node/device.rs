//! What the maker of a device declares: its objects, its PDOs, its names.

use super::{Communication, Node, Outbox};
use crate::heartbeat::ConsumerSlots;
use crate::od::Objects;
use crate::pdo::{PdoSet, PdoSlots};
use crate::time::{LocalClock, LocalUtc};
use crate::types::{AbortCode, Address, CobId, Instant, NodeId, UtcRelation};

/// A device, for a [`Slave`](super::Slave) or a [`Master`](super::Master): the objects of its application, its PDOs, and what
/// its communication profile is at power-on.
///
/// `#[objects(device)]` beside the derive makes `cargo check` refuse a device that cannot be; without it the build of the
/// image does.
///
/// ```
/// use ecss_can::heartbeat::HeartbeatConsumers;
/// use ecss_can::node::{Communication, Device, Identity};
/// use ecss_can::od::Objects;
/// use ecss_can::pdo::{CobIdOf, PdoObjects, PdoSet, Tpdo};
/// use ecss_can::types::NodeId;
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
///     const PDOS: PdoSet = PdoSet::new(&[], &[Tpdo::new(2, CobIdOf::node(0x280)).map(Thermometer::TEMPERATURE)]);
///
///     fn communication(id: NodeId) -> Communication {
///         Communication { device_name: "Thermometer", ..Communication::new(id) }
///     }
/// }
/// ```
pub trait Device: Objects + Default + 'static {
    /// Its PDO slots, those that only clients configure included.
    type Pdos: PdoSlots;
    /// Its entries of 1016h. In a slave the first one is for the master.
    type Consumers: ConsumerSlots;

    /// PDOs at power-on and after reset communication.
    const PDOS: PdoSet;
    /// COB-IDs whose frames a master hands to its application as they are: for what no PDO covers.
    const RAW_FRAMES: &'static [CobId] = &[];

    /// Bits of fine time that it keeps, 0 to 24: those below are sent as zero and not looked at (ECSS 7.1.2g, h).
    const FINE_BITS: u32 = 24;
    /// What UTC it is by the SCET, for a device that has the objects of [`LocalUtc`].
    const UTC: Option<UtcRelation> = None;
    /// Whether it keeps submilliseconds of the UTC (ECSS 7.1.3f, g).
    const SUBMILLISECONDS: bool = true;

    /// Its objects 2012h and 2013h, if it keeps UTC.
    fn utc(&mut self) -> Option<&mut LocalUtc> {
        None
    }

    /// The communication profile at power-on and after reset communication: names and identity, and whatever else is not as
    /// [`Communication::new`] has it.
    fn communication(id: NodeId) -> Communication {
        Communication::new(id)
    }

    /// 1016h at power-on and after reset communication. The node fills in the master's entry itself.
    fn consumers(_id: NodeId) -> Self::Consumers {
        Self::Consumers::default()
    }

    /// PDO parameters at power-on and after reset communication: those of [`Device::PDOS`].
    fn pdos(id: NodeId) -> Self::Pdos {
        Self::Pdos::at_power_on(id, &Self::PDOS)
    }
}

/// A node with the objects of a device: what its application does with them.
pub trait DeviceNode: Node {
    /// The device.
    type Device: Device;

    /// Changes objects of the application. Each PDO that is sent on events goes out when it carries something else
    /// afterwards, as its transmission type and its inhibit time have it.
    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut Self::Device) -> R) -> R;

    /// Writes an object, of a service or of the application, as a client of the SDO server does: with the same checks, and
    /// what depends on it follows.
    ///
    /// # Errors
    /// The abort code that a client would be answered; nothing has changed.
    fn write(
        &mut self,
        at: Address,
        value: &[u8],
        now: Instant,
        out: &mut Outbox<Self::Event, Self::Depth>,
    ) -> Result<(), AbortCode>;
}

/// A node that keeps the spacecraft time.
pub trait TimeKeeper: Node {
    /// Its clock.
    fn spacecraft_clock(&self) -> &LocalClock;
}
