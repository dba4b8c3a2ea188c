//! Rules of the standby that tests break on purpose.

use super::Standby;
use crate::redundancy::Broken;

impl Standby {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.broken = broken;
    }
}
