//! Rules of the selector that tests break on purpose.

use super::{Phase, Selection, Selector};
use crate::redundancy::Broken;
use crate::types::{Bus, Instant};

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
}
