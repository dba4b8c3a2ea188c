//! Objects 1001h, 1003h, 1014h and 1015h, and the rules for writing them.

use super::Config;
use crate::od::{CobIdEntry, EntryUse, INVALID, Objects, Record};
use crate::types::{AbortCode, Address};

/// Objects of the emergency service (CiA 301 7.5.2).
#[doc(alias("1001h", "1003h", "1014h", "1015h", "COB-ID EMCY", "inhibit time EMCY"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct EmcyObjects {
    /// Error register
    #[object(0x1001, ro, pdo)]
    pub register: u8,
    /// Pre-defined error field
    #[object(0x1003, record, array)]
    pub errors: ErrorField,
    /// COB-ID EMCY
    #[object(0x1014, rw, default = INVALID)]
    pub cob_id: u32,
    /// Inhibit time EMCY
    ///
    /// Multiples of 100 us. Ten a second: an error that comes and goes must not fill the bus.
    #[object(0x1015, rw, default = 1_000)]
    pub inhibit: u16,
}

/// Pre-defined error field (1003h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
pub struct ErrorField {
    /// Number of errors
    #[sub(0, rw, volatile)]
    pub count: u8,
    /// Standard error field
    ///
    /// The newest first: error code in the low half, information of the manufacturer in the high one.
    #[sub(1.., ro)]
    pub errors: [u32; 8],
}

pub(super) const REGISTER: u16 = EmcyObjects::REGISTER.index();
pub(super) const ERRORS: u16 = EmcyObjects::ERRORS.index();
pub(super) const COB_ID: u16 = EmcyObjects::COB_ID.index();
pub(super) const INHIBIT: u16 = EmcyObjects::INHIBIT.index();

impl EmcyObjects {
    /// Returns the parameters for the [`Producer`](super::Producer).
    #[inline(never)] // smaller: it has several callers, all of them rare
    pub const fn config(&self) -> Config {
        Config::new(self.cob_id, self.inhibit)
    }

    /// Returns whether there is a value to read. Sub-indices of 1003h above the last error have none.
    pub(crate) fn has_data(&self, at: Address) -> bool {
        at.index != ERRORS || at.sub <= self.errors.count
    }

    /// Checks a `value` that a client writes. Zero to 1003h removes the errors. Accepts every value for objects of
    /// other services.
    ///
    /// # Errors
    /// As [`CobIdEntry::written`]; [`AbortCode::ValueRange`] for another value than zero to 1003h.
    pub(crate) fn may_write(&self, at: Address, value: u32) -> Result<(), AbortCode> {
        match (at.index, at.sub) {
            (ERRORS, 0) if value != 0 => Err(AbortCode::ValueRange),
            (COB_ID, _) => CobIdEntry::from_raw(self.cob_id).written(value, EntryUse::Emcy).map(drop),
            _ => Ok(()),
        }
    }
}
