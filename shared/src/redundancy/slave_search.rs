//! Search of a master for its slaves: it changes the bus by itself, at most Ntoggle times while it hears none.

use super::Parameters;
use crate::types::{Canonical, Duration, Instant};

/// State of the search. Ctoggle counts its changes of the bus ([`Parameters::ctoggle`]).
///
/// A search begins with the first change of the bus after a slave was heard, or after power-on. It ends when a
/// slave that counts is heard on either bus.
///
/// A *dwell* is the time that the master stays on a bus on which it hears no slave. It runs from power-on, from the
/// last change, or from the last frame of a slave that counts, whichever was last: frames of two buses may be
/// reported out of order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = Parameters)]
pub(super) struct SlaveSearch {
    #[canonical(age = self.dwell(context))]
    dwells_since: Instant,
    shortest_dwell: Duration,
    /// A slave was heard since the last change: the next change begins a search.
    #[canonical(value = self.heard && Self::is_limited(context))]
    heard: bool,
    /// All changes were in vain. The master stays, and no dwell runs.
    gave_up: bool,
}

impl SlaveSearch {
    pub const fn new(shortest_dwell: Duration) -> SlaveSearch {
        SlaveSearch { dwells_since: Instant::ZERO, shortest_dwell, heard: false, gave_up: false }
    }

    /// Forgets the search: power-on, or the bus is another one by command.
    pub fn restart(&mut self, now: Instant, parameters: &mut Parameters) {
        (self.heard, self.gave_up) = (false, false);
        self.dwells_since = self.dwells_since.max(now);
        parameters.ctoggle = 0;
    }

    /// Counts a change of the bus (ECSS Table 8-2, Ctoggle).
    pub fn on_change(&mut self, now: Instant, parameters: &mut Parameters) {
        if core::mem::take(&mut self.heard) {
            parameters.ctoggle = 0;
        }
        parameters.ctoggle = parameters.ctoggle.saturating_add(1);
        self.dwells_since = self.dwells_since.max(now);
    }

    /// Notes that a slave was heard: the master may change the bus again.
    pub fn on_heard(&mut self, at: Instant) {
        self.dwells_since = self.dwells_since.max(at);
        (self.heard, self.gave_up) = (true, false);
    }

    /// Lets the dwell begin at `now` if it begins later: a bit flipped.
    pub fn confine(&mut self, now: Instant) {
        self.dwells_since = self.dwells_since.min(now);
    }

    /// Gives the search up.
    pub fn give_up(&mut self) {
        self.gave_up = true;
    }

    /// Returns whether the master may change the bus by itself (ECSS Table 8-2, Ttoggle and Ntoggle).
    pub fn may_change(&self, parameters: &Parameters) -> bool {
        let Parameters { ttoggle, ntoggle, ctoggle, .. } = *parameters;
        let is_enabled = ttoggle > 0 && ntoggle > 0;
        is_enabled && (self.heard || ntoggle == Parameters::NO_LIMIT || ctoggle < ntoggle)
    }

    /// Returns the parameters without a Ctoggle that decides nothing, because the number of changes has no limit.
    pub fn counting(parameters: Parameters) -> Parameters {
        Parameters {
            ctoggle: if Self::is_limited(&parameters) { parameters.ctoggle } else { 0 },
            ..parameters
        }
    }

    const fn is_limited(parameters: &Parameters) -> bool {
        parameters.ntoggle != Parameters::NO_LIMIT
    }

    pub const fn dwell(&self, parameters: &Parameters) -> Duration {
        parameters.dwell(self.shortest_dwell)
    }

    /// Returns the end of the dwell. `None` while slaves are not monitored, after giving up, and while switching is
    /// disabled.
    pub fn dwells_until(&self, parameters: &Parameters) -> Option<Instant> {
        let is_searching = parameters.toggling_enabled() && !self.gave_up;
        is_searching.then(|| self.dwells_since + self.dwell(parameters))
    }
}
