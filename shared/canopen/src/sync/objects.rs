//! Objects 1005h to 1007h and 1019h, and the rules for writing them.

use super::{Config, check_overflow, check_period};
use crate::od::{CobIdEntry, EntryUse, Objects};
use crate::types::{AbortCode, Address, CobId};

/// Objects of SYNC (CiA 301 7.5.2).
#[doc(alias("1005h", "1006h", "1007h", "1019h", "COB-ID SYNC", "communication cycle period"))]
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct SyncObjects {
    /// COB-ID SYNC message
    #[object(0x1005, rw, default = 0x80)]
    pub cob_id: u32,
    /// Communication cycle period
    ///
    /// Microseconds.
    #[object(0x1006, rw)]
    pub cycle_period: u32,
    /// Synchronous window length
    ///
    /// Microseconds.
    #[object(0x1007, rw)]
    pub window: u32,
    /// Synchronous counter overflow value
    #[object(0x1019, rw, high = 240)]
    pub overflow: u8,
}

pub(super) const COB_ID: u16 = SyncObjects::COB_ID.index();
pub(super) const CYCLE_PERIOD: u16 = SyncObjects::CYCLE_PERIOD.index();
pub(super) const WINDOW: u16 = SyncObjects::WINDOW.index();
pub(super) const OVERFLOW: u16 = SyncObjects::OVERFLOW.index();

impl SyncObjects {
    /// Returns the COB-ID of SYNC.
    pub const fn id(&self) -> CobId {
        CobIdEntry::from_raw(self.cob_id).id()
    }

    /// Returns the parameters for the [`Producer`](super::Producer).
    pub const fn config(&self) -> Config {
        Config::new(self.cob_id, self.cycle_period, self.overflow)
    }

    /// Checks a `value` that a client writes. Only in the master `is_producer` is `true`. Accepts every
    /// value for objects of other services.
    ///
    /// # Errors
    /// As [`CobIdEntry::written`], [`check_period`] and [`check_overflow`]. [`AbortCode::ValueRange`] if a slave
    /// would produce SYNC.
    pub(crate) fn may_write(&self, at: Address, value: u32, is_producer: bool) -> Result<(), AbortCode> {
        match at.index {
            COB_ID if !is_producer && CobIdEntry::from_raw(value).flag() => Err(AbortCode::ValueRange),
            COB_ID => CobIdEntry::from_raw(self.cob_id).written(value, EntryUse::Sync).map(drop),
            CYCLE_PERIOD => check_period(value),
            OVERFLOW => check_overflow(value as u8, self.cycle_period),
            _ => Ok(()),
        }
    }
}
