//! Parameters of the producer.

use crate::od::CobIdEntry;
use crate::types::{CobId, Duration};

/// Values of objects 1014h and 1015h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// COB-ID (1014h). `None` if not valid: no message is sent, but history and error register are kept.
    pub id: Option<CobId>,
    /// Least time between two messages (1015h).
    pub inhibit: Duration,
}

impl Config {
    /// Takes the values of 1014h and 1015h. `inhibit` is in units of 100 us.
    pub const fn new(cob_id: u32, inhibit: u16) -> Self {
        Config {
            id: CobIdEntry::from_raw(cob_id).cob_id(),
            inhibit: Duration::from_micros(inhibit as u64 * 100),
        }
    }
}
