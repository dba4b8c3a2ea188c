//! Rules of the peers that tests break on purpose.

use crate::redundancy::Broken;

/// Slaves that somebody else stopped stay so, where that rule is broken.
pub(super) fn leaves_stopped(broken: Option<Broken>) -> bool {
    broken == Some(Broken::LeavesStopped)
}
