//! Objects 1010h and 1011h, and the requests that clients make by writing to them.

use super::{LOAD, SAVE};
use crate::od::Objects;
use crate::types::AbortCode;

/// Objects of the parameter store (CiA 301 7.5.2).
#[doc(alias("1010h", "1011h"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct StoreObjects {
    /// Store parameters
    ///
    /// All, communication, application, manufacturer. Bit 0: on command; zero without a parameter store.
    #[object(0x1010, array, rw, volatile)]
    pub store: [u32; 4],
    /// Restore default parameters
    ///
    /// All, communication, application, manufacturer. Bit 0: possible; zero without a parameter store.
    #[object(0x1011, array, rw, volatile)]
    pub restore: [u32; 4],
}

const STORE: u16 = StoreObjects::STORE.index();
const RESTORE: u16 = StoreObjects::RESTORE.index();

/// Request of a client to the parameter store. The sub-index of its object is that of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreRequest {
    /// Save the present values.
    Save,
    /// Restore the defaults.
    Restore,
}

impl StoreRequest {
    /// Returns the request of a write to this object. `None` for objects of other services.
    pub const fn of(index: u16) -> Option<StoreRequest> {
        match index {
            STORE => Some(StoreRequest::Save),
            RESTORE => Some(StoreRequest::Restore),
            _ => None,
        }
    }

    /// Checks that `value` is the signature of this request. It is not stored as the value of the object: a read
    /// returns the capabilities of the device.
    ///
    /// # Errors
    /// [`AbortCode::CannotTransfer`] for any other value.
    pub const fn check(self, value: u32) -> Result<(), AbortCode> {
        let signature = match self {
            StoreRequest::Save => SAVE,
            StoreRequest::Restore => LOAD,
        };
        if value == signature { Ok(()) } else { Err(AbortCode::CannotTransfer) }
    }
}

impl StoreObjects {
    /// Sets the values of the objects: they show whether the device has a parameter store.
    pub fn show(&mut self, has_store: bool) {
        self.store = [u32::from(has_store); 4];
        self.restore = self.store;
    }
}
