//! Acceptance filters that the master has sent to its buses.

use async_canopen::node::extend::Part;

use crate::link::port::Filter;
use crate::types::{CobId, Duration, Instant};

/// Retry interval for changed filters.
const FILTER_PAUSE: Duration = Duration::from_millis(1);
/// Function codes of COB-IDs.
pub(super) const FUNCTIONS: u16 = 16;

/// Filters that the buses have, without the last one.
#[derive(Debug)]
pub(super) struct SentFilters {
    filters: [Filter; FUNCTIONS as usize],
    /// Some may have changed.
    is_due: bool,
    /// Those that found no room wait for a short pause.
    not_before: Instant,
}

impl SentFilters {
    pub const fn new() -> Self {
        let filters = [Filter::exact(CobId::NMT); FUNCTIONS as usize];
        SentFilters { filters, is_due: false, not_before: Instant::ZERO }
    }

    /// Notes that COB-IDs of RPDOs changed.
    pub fn note_change(&mut self) {
        (self.is_due, self.not_before) = (true, Instant::ZERO);
    }

    /// Returns whether the buses have `filter` under this number.
    pub fn has(&self, number: u16, filter: Filter) -> bool {
        self.filters.get(usize::from(number)) == Some(&filter)
    }

    /// Notes that the buses have `filter` under this number.
    pub fn set(&mut self, number: u16, filter: Filter) {
        if let Some(sent) = self.filters.get_mut(usize::from(number)) {
            *sent = filter;
        }
    }

    /// Forgets what was sent: each filter is sent again.
    pub fn forget(&mut self) {
        self.filters = [Filter::ALL; FUNCTIONS as usize];
        self.note_change();
    }

    /// Notes that the filters were sent at `now`, except those that found no room.
    pub fn on_sent(&mut self, are_all: bool, now: Instant) {
        (self.is_due, self.not_before) = (!are_all, now + FILTER_PAUSE);
    }
}

impl Part for SentFilters {
    fn earliest(&self) -> Option<Instant> {
        self.is_due.then_some(self.not_before)
    }
}
