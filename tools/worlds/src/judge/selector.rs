//! Parameters of the redundancy of one slave, object 2000h (ECSS 8.3.3).

use ecss_can::redundancy::{BusCause, Parameters};
use ecss_can::types::Bus;

/// Returns whether a search had too many switches (ECSS 8.3.3h): Ctoggle is at most Ntoggle.
pub fn is_toggled_too_often(parameters: &Parameters) -> bool {
    parameters.ctoggle > parameters.ntoggle
}

/// Returns whether Bdefault is correct after a step of a slave, which may have reported its active bus. Bdefault
/// becomes this bus when the master is found or followed (ECSS 8.3.3k, l). It may return when one of these is reverted,
/// and changes for no other reason.
pub fn is_bdefault_right(before: Bus, after: Bus, reported: Option<(BusCause, Bus)>) -> bool {
    match reported {
        Some((BusCause::Found | BusCause::Followed, bus)) => after == bus,
        Some((BusCause::TakenBack | BusCause::Unconfirmed, _)) => true,
        _ => after == before,
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::profile::Profile;

    use super::*;

    /// Verifies: ECSS 8.3.3h
    #[test]
    fn ctoggle_above_ntoggle_is_too_often() {
        for (ctoggle, ntoggle, expected) in [(0, 0, false), (4, 4, false), (5, 4, true), (255, 255, false)] {
            let parameters = Parameters { ctoggle, ntoggle, ..Profile::DEFAULT.redundancy() };
            assert_eq!(is_toggled_too_often(&parameters), expected, "{ctoggle} of {ntoggle}");
        }
    }

    /// Given Bdefault Nominal and a report of the active bus. Then both keeping and changing it are allowed.
    ///
    /// Verifies: ECSS 8.3.3k, 8.3.3l
    #[test]
    fn bdefault_changes_with_a_find_a_follow_and_their_return() {
        let bus = Bus::Redundant;
        for (reported, may_keep, may_change) in [
            (None, true, false),
            (Some((BusCause::Found, bus)), false, true),
            (Some((BusCause::Found, Bus::Nominal)), true, false),
            (Some((BusCause::Followed, bus)), false, true),
            (Some((BusCause::TakenBack, bus)), true, true),
            (Some((BusCause::Unconfirmed, bus)), true, true),
            (Some((BusCause::Toggled, bus)), true, false),
            (Some((BusCause::PowerOn, bus)), true, false),
            (Some((BusCause::Selected, bus)), true, false),
        ] {
            let found = Bus::ALL.map(|after| is_bdefault_right(Bus::Nominal, after, reported));
            assert_eq!(found, [may_keep, may_change], "{reported:?}");
        }
    }
}
