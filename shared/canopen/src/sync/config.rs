//! Parameters of the producer.

use crate::od::CobIdEntry;
use crate::types::{CobId, Duration};

/// Parameters of the production of SYNC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// COB-ID of the SYNC.
    pub id: CobId,
    /// Communication cycle period. Zero: SYNC is not produced.
    pub period: Duration,
    /// Greatest value of the counter, which starts at 1. Zero: no counter.
    pub overflow: u8,
}

impl Config {
    /// Takes the values of 1005h (bit 30: SYNC is produced), 1006h (microseconds) and 1019h.
    pub const fn new(cob_id: u32, period: u32, overflow: u8) -> Config {
        let entry = CobIdEntry::from_raw(cob_id);
        let period = if entry.flag() { Duration::from_micros(period as u64) } else { Duration::ZERO };
        Config { id: entry.id(), period, overflow }
    }
}
