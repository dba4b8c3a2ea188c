//! Rules of the manager that tests break on purpose.

use super::Manager;
use crate::redundancy::Broken;

impl<const N: usize> Manager<N> {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.broken = broken;
        self.peers.broken = broken;
    }

    /// Returns whether this rule is broken.
    pub fn is_broken(&self, rule: Broken) -> bool {
        self.broken == Some(rule)
    }
}
