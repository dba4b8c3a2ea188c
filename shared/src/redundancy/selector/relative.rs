//! Shifts the clock of the selector, for the model checker.

use super::{Phase, Selection, Selector};
use crate::redundancy::Broken;
use crate::types::{Bus, Instant, PerBus, Rebase};

impl Selector {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.broken = broken;
    }

    /// Returns whether this rule is broken.
    pub fn is_broken(&self, rule: Broken) -> bool {
        self.broken == Some(rule)
    }

    /// A slave that follows a master goes to the other bus with any message there.
    pub(super) fn follows_everybody(&self) -> bool {
        let is_following = matches!(self.phase, Phase::Following { .. });
        is_following && self.is_broken(Broken::FollowsEverybody)
    }

    pub(super) fn follow_at_once(&mut self, bus: Bus, at: Instant) -> Option<Selection> {
        self.follow(bus, bus, at);
        Some(Selection::Followed { to: bus })
    }

    /// Bdefault after a find.
    pub(super) fn bdefault_after_find(&self, bdefault: Bus) -> Bus {
        if self.is_broken(Broken::KeepsBdefault) { self.parameters.bdefault } else { bdefault }
    }

    /// The bus where it is after it found the master on `bus`.
    pub(super) fn after_follow(&self, bus: Bus) -> Bus {
        let is_following = matches!(self.phase, Phase::Following { .. });
        let stays = is_following && self.broken == Some(Broken::StaysBehind);
        if stays { self.selected } else { bus }
    }

    /// Switches of a search at most, before one of them.
    pub(super) fn before_toggle(&mut self, ntoggle: u8) -> u8 {
        match self.broken {
            Some(Broken::TogglesOnceMore) => ntoggle.saturating_add(1),
            Some(Broken::BdefaultByToggle) => {
                self.parameters.bdefault = self.selected.other();
                ntoggle
            }
            _ => ntoggle,
        }
    }

    /// Shifts the clock from `now`, when everything due was polled. `frames`: as for [`Selector::on_work`].
    /// Returns the counts to continue with.
    pub fn rebase(&mut self, frames: PerBus<u32>, now: Instant) -> PerBus<u32> {
        let (to, parameters) = (Rebase::new(now), self.parameters);
        // Later than that, a switch that is overdue does not count from its time.
        let late = parameters.toggling_time().times(2);
        match &mut self.phase {
            Phase::Following { last } => {
                *last = to.aged(*last, parameters.consumer);
                // Shows the last search, decides nothing.
                self.parameters.ctoggle = 0;
            }
            Phase::Unconfirmed { until, search, .. } => {
                *until = to.due(*until);
                search.since = search.since.map(|since| to.aged(since, late));
            }
            Phase::Searching(search) => {
                search.since = search.since.map(|since| to.aged(since, late));
            }
        }
        self.rhythm.rebase();
        self.moved = self.moved.and_then(|moved| moved.rebased(&to, &parameters, now));
        self.hold_off = self.hold_off.map(|until| to.due(until));
        self.keep = self.keep.map(|(at, bus)| (to.due(at), bus));
        self.on_work(frames);
        if self.moved.is_none() && self.hold_off.is_none() {
            // The next move looks at what comes after it.
            self.work.restart(now);
        }
        self.work.rebase(&to, parameters.consumer.max(parameters.producer).times(2));
        self.work.frames
    }
}
