//! Objects 1010h and 1011h, and what is asked for by writing to them.

use super::{LOAD, SAVE};
use crate::od::Objects;
use crate::types::AbortCode;

/// Objects of the parameter store (CiA 301 7.5.2).
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

/// What a client asks of the parameter store. The sub-index of its object is that of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreRequest {
    /// Save the present values.
    Save,
    /// Restore the defaults.
    Restore,
}

impl StoreRequest {
    /// The request that a write to this object is; `None` for the objects of others.
    pub const fn of(index: u16) -> Option<StoreRequest> {
        match index {
            STORE => Some(StoreRequest::Save),
            RESTORE => Some(StoreRequest::Restore),
            _ => None,
        }
    }

    /// Whether `value` is the signature of this request. It is no value of the object: what is read back is what the device
    /// can do.
    ///
    /// # Errors
    /// [`AbortCode::CannotTransfer`].
    pub const fn check(self, value: u32) -> Result<(), AbortCode> {
        let signature = match self {
            StoreRequest::Save => SAVE,
            StoreRequest::Restore => LOAD,
        };
        if value == signature { Ok(()) } else { Err(AbortCode::CannotTransfer) }
    }
}

impl StoreObjects {
    /// Shows whether the device has a parameter store.
    pub fn show(&mut self, has_store: bool) {
        self.store = [u32::from(has_store); 4];
        self.restore = self.store;
    }
}
