//! Events of receive PDOs.

use core::fmt;

use super::named::{Pdo, Received};
use super::values::PdoValues;
use super::{CobIdOf, PdoSet};
use crate::types::{Bus, Duration, Instant, NodeId};

/// Receive PDO that took effect. Values that the device has objects for are in the dictionary.
///
/// ```
/// # use async_canopen::pdo::{CobIdOf, Pdo, PdoSet, ReceivedPdo};
/// # use async_canopen::types::{Bus, Duration, Instant, NodeId};
/// # const CHANGE: Pdo<(), (i16, u8)> = Pdo::new(CobIdOf::node(0x280)).skip().skip();
/// # const HEATER: NodeId = NodeId::of::<5>();
/// # const PDOS: PdoSet = PdoSet::new(&[CHANGE.of(HEATER).receive(1)], &[]);
/// # let at = Instant::ZERO;
/// # let pdo = ReceivedPdo::new(&PDOS, 0, Bus::Nominal, [0x90, 0x01, 100, 0, 0, 0, 0, 0], at);
/// if let Some((temperature, power)) = pdo.get(CHANGE.of(HEATER)) {
///     assert_eq!((temperature, power), (400, 100));
/// }
/// // Of two equal devices: which one sent it?
/// assert_eq!(pdo.from(CHANGE), Some((HEATER, (400, 100))));
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ReceivedPdo {
    // An event is moved in words: the parts are those of `SetRpdo` and of `Bus` without their padding.
    set: &'static PdoSet,
    number: u16,
    is_redundant: bool,
    /// Payload, zero above its length. The dictionary may already have a newer one.
    pub data: [u8; 8],
    /// End of the frame, microseconds: the low bits are enough.
    at: u32,
}

/// Receive PDO of a set, synchronous, that took effect at a SYNC.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct SetRpdo {
    set: &'static PdoSet,
    number: u16,
}

impl ReceivedPdo {
    /// Makes the event of receive PDO `number` of a set (0 is the first), whose frame ended at `at`.
    pub fn new(set: &'static PdoSet, number: u16, bus: Bus, data: [u8; 8], at: Instant) -> Self {
        let is_redundant = bus == Bus::Redundant;
        ReceivedPdo { set, number, is_redundant, data, at: at.as_micros() as u32 }
    }

    /// Returns the bus on which it arrived.
    pub const fn bus(&self) -> Bus {
        if self.is_redundant { Bus::Redundant } else { Bus::Nominal }
    }

    /// Returns the values if it is this PDO. They are those of the frame, by the declaration: a client that maps others does
    /// not change their meaning here. Also `None` if one of them is no value of its [enumeration](macro@crate::od::Enumeration):
    /// [`ReceivedPdo::is`] is `true` then, and `data` has the payload.
    pub fn get<P: Received>(&self, pdo: P) -> Option<P::Values> {
        if self.is(pdo) { P::Values::unpack(u64::from_le_bytes(self.data)) } else { None }
    }

    /// Returns whether it is this PDO.
    pub fn is(&self, pdo: impl Received) -> bool {
        self.name().is(pdo)
    }

    /// Returns sender and values if it is this PDO of any node. `None` as in [`ReceivedPdo::get`].
    pub fn from<D, T: PdoValues>(&self, pdo: Pdo<D, T>) -> Option<(NodeId, T)> {
        let node = pdo.cob_id().node_of(self.name().declared()?)?;
        Some((node, T::unpack(u64::from_le_bytes(self.data))?))
    }

    /// Returns the time since the end of the frame. It is at most 71 minutes.
    pub const fn age(&self, now: Instant) -> Duration {
        Duration::from_micros((now.as_micros() as u32).wrapping_sub(self.at) as u64)
    }

    /// Returns the number of the PDO in its device; 0 is the first.
    pub const fn number(&self) -> u16 {
        self.number
    }

    const fn name(&self) -> SetRpdo {
        SetRpdo { set: self.set, number: self.number }
    }
}

impl SetRpdo {
    /// Makes the name of receive PDO `number` of a set (0 is the first).
    pub const fn new(set: &'static PdoSet, number: u16) -> Self {
        SetRpdo { set, number }
    }

    /// Returns whether it is this PDO.
    pub fn is(&self, pdo: impl Received) -> bool {
        self.declared() == Some(pdo.declared_as())
    }

    /// Returns the number of the PDO in its device; 0 is the first.
    pub const fn number(&self) -> u16 {
        self.number
    }

    /// `None`: a client has configured it, and no declaration.
    fn declared(&self) -> Option<CobIdOf> {
        self.set.rpdo(usize::from(self.number)).map(|rpdo| rpdo.pdo().cob_id)
    }
}

impl fmt::Debug for SetRpdo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RPDO {}", self.number.saturating_add(1))
    }
}

impl fmt::Debug for ReceivedPdo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} on {:?}: {:02X?}", self.name(), self.bus(), self.data)
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for SetRpdo {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "RPDO {=u16}", self.number.saturating_add(1));
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for ReceivedPdo {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{} on {}: {=[u8; 8]:02X}", self.name(), self.bus(), self.data);
    }
}
