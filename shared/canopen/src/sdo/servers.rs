//! SDO servers of a device: the default one (1200h) alone, or another one beside it.

use core::fmt::Debug;

use super::SdoServerObjects;
use crate::od::Objects;
use crate::types::{AbortCode, Address, NodeId};

/// Objects of the SDO servers of a device, and storage for what a node keeps of the second one. [`SdoServerObjects`] has the
/// default server alone, and such a node keeps nothing.
pub trait SdoServers: Objects + Default + Clone + Debug + PartialEq + 'static {
    /// Index of the object of the second server. `None`: there is no second server.
    const SECOND_SERVER: Option<u16>;

    /// Storage of a value for the second server: an array with one element, or with none.
    type Second<T: Debug>: AsRef<[T]> + AsMut<[T]> + Debug;

    /// Makes the storage of a value for the second server.
    fn second<T: Debug>(make: impl FnMut() -> T) -> Self::Second<T>;

    /// Returns the objects of a node at power-on.
    fn at_power_on(id: NodeId) -> Self;

    /// Returns the COB-ID entries of the second server: of its requests, then of its answers.
    fn cob_ids(&self) -> Option<[u32; 2]> {
        None
    }

    /// Returns the COB-ID entries of the second server, to be changed.
    fn cob_ids_mut(&mut self) -> Option<[&mut u32; 2]> {
        None
    }

    /// Checks a `value` that a client writes. Accepts every value for objects of other services.
    ///
    /// # Errors
    /// The abort code to answer.
    fn may_write(&self, _at: Address, _value: u32) -> Result<(), AbortCode> {
        Ok(())
    }
}

impl SdoServers for SdoServerObjects {
    const SECOND_SERVER: Option<u16> = None;

    type Second<T: Debug> = [T; 0];

    fn second<T: Debug>(_make: impl FnMut() -> T) -> [T; 0] {
        []
    }

    fn at_power_on(id: NodeId) -> Self {
        Self::of(id)
    }
}
