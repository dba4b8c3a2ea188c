//! Rules of a slave that tests break on purpose.

use super::SlaveRedundancy;
use crate::redundancy::Broken;

impl SlaveRedundancy {
    /// Breaks a rule, for tests.
    pub fn break_rule(&mut self, broken: Option<Broken>) {
        self.selector.break_rule(broken);
    }
}
