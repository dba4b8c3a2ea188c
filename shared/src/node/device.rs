//! What a device of a spacecraft declares beyond CANopen.

use super::{Device, Node};
use crate::time::{LocalClock, LocalUtc};
use crate::types::UtcRelation;

/// How exactly a device keeps the spacecraft time.
///
/// `#[objects(device)]` implements it with the values below. A device with others says `#[objects(device, time)]`, and has an
/// implementation of its own:
///
/// ```
/// use ecss_can::node::DeviceTime;
/// use ecss_can::prelude::*;
///
/// /// A thermometer that keeps 16 bits of fine time.
/// #[derive(Objects)]
/// #[objects(device, time)]
/// struct Thermometer {
///     /// Temperature
///     #[object(0x6000, ro, pdo)]
///     temperature: i16,
/// }
///
/// impl DeviceTime for Thermometer {
///     const FINE_BITS: u32 = 16;
/// }
/// # impl Device for Thermometer {
/// #     type Pdos = PdoObjects<4, 4>;
/// #     type Consumers = HeartbeatConsumers<1>;
/// #     const PDOS: PdoSet = PdoSet::NONE;
/// # }
/// ```
#[diagnostic::on_unimplemented(
    message = "the declaration of `{Self}` does not say that it is a device",
    label = "add `#[objects(device)]` to the declaration of `{Self}`",
    note = "`#[objects(device)]` implements `DeviceTime`; `#[objects(device, time)]` leaves that to you"
)]
pub trait DeviceTime {
    /// Number of bits of fine time that the device keeps, 0 to 24. The lower bits are sent as zero and ignored in
    /// reception (ECSS 7.1.2g, h).
    const FINE_BITS: u32 = 24;
    /// Relation of UTC and SCET, for a device that has the objects of [`LocalUtc`].
    const UTC: Option<UtcRelation> = None;
    /// `true`: the device keeps the submilliseconds of UTC (ECSS 7.1.3f, g).
    const SUBMILLISECONDS: bool = true;

    /// Returns the objects 2012h and 2013h if the device keeps UTC.
    fn utc(&mut self) -> Option<&mut LocalUtc> {
        None
    }
}

/// Device for a [`Slave`](super::Slave) or a [`Master`](super::Master).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a device",
    label = "needs `impl Device for {Self}`",
    note = "add `impl Device for {Self}`, and `#[objects(device)]` beside `#[derive(Objects)]`"
)]
pub trait SpacecraftDevice: Device + DeviceTime {}

#[diagnostic::do_not_recommend]
impl<D: Device + DeviceTime> SpacecraftDevice for D {}

/// Node that keeps the spacecraft time.
pub trait TimeKeeper: Node {
    /// Returns the local clock.
    fn spacecraft_clock(&self) -> &LocalClock;
}
