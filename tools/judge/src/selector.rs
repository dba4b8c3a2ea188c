//! Parameters of the redundancy of one slave, object 2000h (ECSS 8.3.3).

use ecss_can::redundancy::{Parameters, Selection};
use ecss_can::types::Bus;

/// Whether a search had more switches than it may (ECSS 8.3.3h): Ctoggle is at most Ntoggle.
pub fn is_toggled_too_often(parameters: &Parameters) -> bool {
    parameters.ctoggle > parameters.ntoggle
}

/// Whether Bdefault is right after a step of a slave, with its decision: it becomes the active bus with a find or a follow
/// (ECSS 8.3.3k, l). It may return when one of these is taken back, and changes for no other reason.
pub fn is_bdefault_right(before: Bus, after: Bus, selection: Option<Selection>) -> bool {
    match selection {
        Some(Selection::Found { bus, .. } | Selection::Followed { to: bus }) => after == bus,
        Some(Selection::Contradicted { moved: true, .. } | Selection::Unconfirmed { .. }) => true,
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

    /// Given Bdefault Nominal and a decision. Then the slave may keep it, and may change it.
    ///
    /// Verifies: ECSS 8.3.3k, 8.3.3l
    #[test]
    fn bdefault_changes_with_a_find_a_follow_and_their_return() {
        let bus = Bus::Redundant;
        for (selection, may_keep, may_change) in [
            (None, true, false),
            (Some(Selection::Found { bus, moved: true }), false, true),
            (Some(Selection::Found { bus: Bus::Nominal, moved: false }), true, false),
            (Some(Selection::Followed { to: bus }), false, true),
            (Some(Selection::Contradicted { bus, moved: true }), true, true),
            (Some(Selection::Contradicted { bus, moved: false }), true, false),
            (Some(Selection::Unconfirmed { bus, moved: false }), true, true),
            (Some(Selection::Toggled { to: bus }), true, false),
            (Some(Selection::Missed { bus }), true, false),
            (Some(Selection::GaveUp { bus }), true, false),
            (Some(Selection::Confirmed), true, false),
        ] {
            let found = Bus::ALL.map(|after| is_bdefault_right(Bus::Nominal, after, selection));
            assert_eq!(found, [may_keep, may_change], "{selection:?}");
        }
    }
}
