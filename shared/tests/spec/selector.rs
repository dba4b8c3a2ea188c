//! Bus selection of a slave: clause 8.3.3 and the corner cases it leaves open.
//!
//! Parameters throughout: consumer time 100 ms, Ttoggle 3, Ntoggle 4, Bdefault nominal, unless a test says otherwise.
//!
//! Verifies: ECSS 8.3.3e, 8.3.3h

use std::hash::{DefaultHasher, Hash, Hasher};

use ecss_can::redundancy::Parameters;
use ecss_can::redundancy::machine::{MasterMessage, Selection, Selector};
use ecss_can::types::Bus;

use crate::bench::{NOMINAL, REDUNDANT, ms, span};
use MasterMessage::{Command, Heartbeat};

const PARAMETERS: Parameters = Parameters {
    consumer: ecss_can::types::Duration::from_millis(100),
    producer: ecss_can::types::Duration::from_millis(40),
    bdefault: Bus::Nominal,
    ttoggle: 3,
    ntoggle: 4,
    ctoggle: 0,
};

fn started(parameters: Parameters) -> Selector {
    let mut selector = Selector::new(parameters);
    selector.start(ms(0));
    selector
}

/// Follows the master on the default bus since 1000 ms.
fn following(parameters: Parameters) -> Selector {
    let mut selector = started(parameters);
    selector.on_master(selector.selected(), Heartbeat, ms(1_000));
    selector
}

/// Every decision up to `until`, with the time each was due.
fn decisions(selector: &mut Selector, until: u64) -> Vec<(u64, Selection)> {
    let mut made = vec![];
    while let Some(at) = selector.deadline().filter(|at| *at <= ms(until)) {
        let selection = selector.poll(at).expect("a deadline has a decision");
        made.push((at.as_micros() / 1_000, selection));
    }
    made
}

fn bdefault(selector: &Selector) -> Bus {
    selector.parameters().bdefault
}

/// Verifies: ECSS 8.3.2a, 8.3.1a
#[test]
fn power_on_selects_the_default_bus_and_clears_ctoggle() {
    for bus in Bus::ALL {
        let selector = started(Parameters { bdefault: bus, ctoggle: 3, ..PARAMETERS });
        assert_eq!(selector.selected(), bus);
        assert_eq!(selector.parameters().ctoggle, 0);
    }
}

/// Verifies: ECSS 8.3.2b, 8.3.1a
/// Notices: ECSS 8.3.2b: after power-on a slave does not toggle before its first heartbeat of the master.
/// Notices: ECSS 8.3.3h: each toggle but the first is one consumer time late.
/// Notices: ECSS 8.3.1a: Ctoggle does not count the changes of a search that begins at power-on.
#[test]
fn search_before_first_heartbeat_runs_from_pre_operational() {
    let mut selector = started(PARAMETERS);
    let toggled = decisions(&mut selector, 1_200);
    assert_eq!(
        toggled,
        [
            (300, Selection::Toggled { to: REDUNDANT }),
            (600, Selection::Toggled { to: NOMINAL }),
            (900, Selection::Toggled { to: REDUNDANT }),
            (1_200, Selection::Toggled { to: NOMINAL }),
        ]
    );
    assert_eq!(selector.parameters().ctoggle, 4);
}

/// Verifies: ECSS 8.3.3i, 8.3.3j
/// Notices: ECSS 8.3.3i: a slave toggles once more than Ntoggle.
#[test]
fn after_an_even_ntoggle_it_listens_on_bdefault() {
    let mut selector = started(PARAMETERS);
    let last = decisions(&mut selector, 100_000).pop();
    assert_eq!(last, Some((1_500, Selection::GaveUp { bus: NOMINAL })));
    assert_eq!(selector.deadline(), None);
}

/// Verifies: ECSS 5.3.3.2.3k.2, 8.3.3j, 8.3.3l, 5.3.3.2.3h, 8.3.3g
/// Notices: ECSS 5.3.3.2.3k.2: a slave that gave up its search does not follow the master.
/// Notices: ECSS 8.3.3j: after an odd Ntoggle a slave goes back to Bdefault.
/// Notices: ECSS 5.3.3.2.3h: a slave that gave up ignores the master that resumes.
#[test]
fn after_an_odd_ntoggle_it_stays_and_a_late_find_is_bdefault() {
    let mut selector = started(Parameters { ntoggle: 3, ..PARAMETERS });
    let last = decisions(&mut selector, 100_000).pop();
    assert_eq!(last, Some((1_200, Selection::GaveUp { bus: REDUNDANT })));
    assert_eq!((selector.selected(), bdefault(&selector)), (REDUNDANT, NOMINAL));
    // A later master message there makes it active and Bdefault: with the old one the next search would end on the bus
    // without a master.
    let late = selector.on_master(REDUNDANT, Heartbeat, ms(9_000));
    assert_eq!(late, Some(Selection::Found { bus: REDUNDANT, moved: false }));
    assert_eq!((selector.selected(), bdefault(&selector)), (REDUNDANT, REDUNDANT));
    assert_eq!(selector.parameters().ctoggle, 3, "the master can read it now");
    // And it is monitored like any active bus.
    assert_eq!(decisions(&mut selector, 9_100), [(9_100, Selection::Missed { bus: REDUNDANT })]);
}

/// Verifies: ECSS 8.3.3e.1, 8.3.3e.2, 8.3.1a, 8.3.3c
/// Notices: ECSS 8.3.3e.2: Ttoggle counts from the miss, not from the last heartbeat.
#[test]
fn miss_after_one_consumer_time_and_toggle_after_ttoggle() {
    let mut selector = following(PARAMETERS);
    selector.on_master(NOMINAL, Heartbeat, ms(1_090));
    let made = decisions(&mut selector, 1_390);
    assert_eq!(
        made,
        [(1_190, Selection::Missed { bus: NOMINAL }), (1_390, Selection::Toggled { to: REDUNDANT })]
    );
    assert_eq!(selector.parameters().ctoggle, 1);
}

/// Given a slave that may change the bus once in a search, when it misses the master again after each search that found it, then it
/// goes to the other bus each time.
///
/// Verifies: ECSS 5.3.3.2.3i, 8.3.3e.2, 8.3.3i, 8.3.2b
/// Notices: ECSS 5.3.3.2.3i: after one search no toggle is left for the next fault.
/// Notices: ECSS 8.3.3e.2: a miss does not reset Ctoggle, so that searches share Ntoggle.
/// Notices: ECSS 8.3.3i: a search begins with the Ctoggle of the last one.
/// Notices: ECSS 8.3.2b: a slave with Ntoggle 1 listens on its first bus alone.
#[test]
fn each_miss_brings_a_switch_however_many_there_were_before() {
    let mut selector = following(Parameters { ntoggle: 1, ..PARAMETERS });
    for (heard, bus, other) in
        [(1_010, NOMINAL, REDUNDANT), (1_350, REDUNDANT, NOMINAL), (1_700, NOMINAL, REDUNDANT)]
    {
        selector.on_master(bus, Heartbeat, ms(heard));
        let made = decisions(&mut selector, heard + 300);
        let expected =
            [(heard + 100, Selection::Missed { bus }), (heard + 300, Selection::Toggled { to: other })];
        assert_eq!(made, expected, "heard at {heard} ms");
    }
}

/// Given a slave that follows the master on the nominal bus, when Bdefault is written and the master is missed, then each switch
/// leaves the bus that was listened to, whatever Bdefault is.
///
/// Verifies: ECSS 8.3.3e.2, 8.3.2b
/// Notices: ECSS 8.3.3e.2: a search begins on Bdefault, not on the bus that was followed.
/// Notices: ECSS 8.3.3e.2: every switch goes to the bus other than Bdefault.
#[test]
fn each_switch_leaves_the_bus_listened_to_with_either_bdefault() {
    for bdefault in Bus::ALL {
        let mut selector = following(PARAMETERS);
        selector.configure(Parameters { bdefault, ..PARAMETERS });
        let expected = [
            (1_100, Selection::Missed { bus: NOMINAL }),
            (1_300, Selection::Toggled { to: REDUNDANT }),
            (1_600, Selection::Toggled { to: NOMINAL }),
        ];
        assert_eq!(decisions(&mut selector, 1_600), expected, "Bdefault {bdefault:?}");
    }
}

/// Verifies: ECSS 8.3.3e.1, 8.3.3e.2
/// Notices: ECSS 8.3.3e.1: with Ttoggle 1 the bus is changed before Pre-operational is entered.
#[test]
fn with_ttoggle_one_miss_and_switch_coincide_in_that_order() {
    let mut selector = following(Parameters { ttoggle: 1, ..PARAMETERS });
    let made = decisions(&mut selector, 1_100);
    assert_eq!(
        made,
        [(1_100, Selection::Missed { bus: NOMINAL }), (1_100, Selection::Toggled { to: REDUNDANT })]
    );
}

#[test]
fn a_late_poll_does_not_shift_the_search() {
    let mut selector = following(PARAMETERS);
    assert_eq!(selector.poll(ms(1_550)), Some(Selection::Missed { bus: NOMINAL }));
    assert_eq!(selector.poll(ms(1_550)), Some(Selection::Toggled { to: REDUNDANT }));
    assert_eq!(selector.poll(ms(1_550)), None);
    assert_eq!(selector.deadline(), Some(ms(1_600)));
}

/// Verifies: ECSS 6.5.2b, 8.3.3c
/// Notices: ECSS 8.3.3c: a heartbeat counts as older by a producer time than it is.
#[test]
fn heartbeats_in_time_keep_the_bus() {
    let mut selector = following(PARAMETERS);
    for at in [1_099, 1_198, 1_297] {
        assert_eq!(selector.poll(ms(at)), None);
        assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(at)), None);
    }
    assert_eq!(selector.deadline(), Some(ms(1_397)));
}

#[test]
fn a_command_on_the_active_bus_is_no_heartbeat() {
    let mut selector = following(PARAMETERS);
    assert_eq!(selector.on_master(NOMINAL, Command, ms(1_090)), None);
    assert_eq!(selector.deadline(), Some(ms(1_100)));
}

/// Verifies: ECSS 8.3.3k, 8.3.3g
#[test]
fn master_back_on_same_bus_between_miss_and_switch_is_found() {
    let mut selector = following(PARAMETERS);
    assert_eq!(selector.poll(ms(1_100)), Some(Selection::Missed { bus: NOMINAL }));
    let found = selector.on_master(NOMINAL, Heartbeat, ms(1_250));
    assert_eq!(found, Some(Selection::Found { bus: NOMINAL, moved: false }));
    assert_eq!(decisions(&mut selector, 1_349), []);
}

/// Verifies: ECSS 8.3.3g, 8.3.3k, 8.3.3l, 8.3.1a
/// Notices: ECSS 8.3.3k: a first heartbeat is taken for a command, and has to be confirmed.
#[test]
fn heartbeat_on_toggled_bus_ends_search_and_sets_bdefault() {
    let mut selector = following(PARAMETERS);
    decisions(&mut selector, 1_300);
    let found = selector.on_master(REDUNDANT, Heartbeat, ms(1_310));
    assert_eq!(found, Some(Selection::Found { bus: REDUNDANT, moved: false }));
    assert_eq!((selector.selected(), bdefault(&selector)), (REDUNDANT, REDUNDANT));
    assert_eq!(selector.parameters().ctoggle, 1, "the master can read it now");
}

/// Verifies: ECSS 8.3.3l
#[test]
fn message_in_toggling_time_after_last_toggle_updates_bdefault() {
    let mut selector = started(Parameters { ntoggle: 1, ..PARAMETERS });
    decisions(&mut selector, 300);
    selector.on_master(REDUNDANT, Heartbeat, ms(599));
    assert_eq!(bdefault(&selector), REDUNDANT);
}

/// Verifies: ECSS 8.3.3g, 8.3.3k, 8.3.3l
/// Notices: ECSS 8.3.3l: Bdefault stays when a search ends on the other bus.
#[test]
fn any_master_message_ends_the_search_also_on_the_other_bus() {
    for message in [Heartbeat, Command] {
        let mut selector = started(PARAMETERS);
        let found = selector.on_master(REDUNDANT, message, ms(50));
        assert_eq!(found, Some(Selection::Found { bus: REDUNDANT, moved: true }));
        assert_eq!((selector.selected(), bdefault(&selector)), (REDUNDANT, REDUNDANT));
        // The active bus is monitored from that message on.
        assert_eq!(selector.deadline(), Some(ms(150)));
    }
}

/// Verifies: ECSS 8.3.3g, 8.3.3l
#[test]
fn parallel_slave_follows_at_once_when_master_changes_bus() {
    let mut selector = following(PARAMETERS);
    let followed = selector.on_master(REDUNDANT, Heartbeat, ms(1_020));
    assert_eq!(followed, Some(Selection::Followed { to: REDUNDANT }));
    assert_eq!((selector.selected(), bdefault(&selector)), (REDUNDANT, REDUNDANT));
    assert_eq!(decisions(&mut selector, 1_120), [(1_120, Selection::Missed { bus: REDUNDANT })]);
}

#[test]
fn late_message_older_than_last_heartbeat_does_not_move_back() {
    let mut selector = following(PARAMETERS);
    selector.on_master(REDUNDANT, Heartbeat, ms(1_020));
    assert_eq!(selector.on_master(NOMINAL, Heartbeat, ms(1_019)), None);
    assert_eq!(selector.selected(), REDUNDANT);
}

/// Verifies: ECSS 8.3.3i, 8.3.3k
#[test]
fn with_ntoggle_zero_switching_is_disabled() {
    let mut selector = following(Parameters { ntoggle: 0, ..PARAMETERS });
    assert_eq!(decisions(&mut selector, 100_000), [(1_100, Selection::Missed { bus: NOMINAL })]);
    let found = selector.on_master(NOMINAL, Heartbeat, ms(2_000));
    assert_eq!(found, Some(Selection::Found { bus: NOMINAL, moved: false }));
}

/// Given a slave with the largest Ntoggle, then it toggles 255 times and gives up. That 255 is no limit holds for the master alone.
///
/// Verifies: ECSS 8.3.3i, 8.3.3j, 8.3.1a
/// Notices: ECSS 8.3.3i: an Ntoggle of 255 is no limit for a slave.
/// Notices: ECSS 8.3.3j: a slave with Ntoggle 255 never stops toggling.
#[test]
fn the_largest_ntoggle_is_a_number_of_switches_too() {
    let mut selector = started(Parameters { ntoggle: 255, ..PARAMETERS });
    let made = decisions(&mut selector, 100_000);
    assert_eq!(made.len(), 256);
    assert_eq!(made.last(), Some(&(256 * 300, Selection::GaveUp { bus: REDUNDANT })));
    assert_eq!(selector.parameters().ctoggle, 255);
}

/// Given a slave whose Ttoggle consumer times are more microseconds than 32 bits can hold, then it listens for all of that time on each
/// bus.
///
/// Notices: ECSS 8.3.3h: Ttoggle consumer times of 4,295 s or more wrap.
#[test]
fn longest_toggling_times_are_listened_to_in_full() {
    for (consumer, ttoggle, toggles) in [(60_000, 100, 6_000_000), (65_535, 255, 16_711_425)] {
        let mut selector = started(Parameters { consumer: span(consumer), ttoggle, ..PARAMETERS });
        let toggled = Selection::Toggled { to: REDUNDANT };
        assert_eq!(decisions(&mut selector, toggles), [(toggles, toggled)]);
        assert_eq!(decisions(&mut selector, 2 * toggles - 1), []);
    }
}

#[test]
fn with_ttoggle_zero_it_never_toggles() {
    let mut selector = started(Parameters { ttoggle: 0, ..PARAMETERS });
    assert_eq!(selector.deadline(), None);
    selector.on_master(NOMINAL, Heartbeat, ms(1_000));
    assert_eq!(decisions(&mut selector, 100_000), [(1_100, Selection::Missed { bus: NOMINAL })]);
}

/// Verifies: ECSS 6.5.2a
/// Notices: ECSS 6.5.2a: a consumer time of zero is over at once.
#[test]
fn with_a_consumer_time_of_zero_nothing_is_monitored() {
    let mut selector = following(Parameters { consumer: span(0), ..PARAMETERS });
    assert_eq!(selector.deadline(), None);
    assert_eq!(selector.poll(ms(100_000)), None);
}

/// Verifies: ECSS 8.3.2b, 8.3.2a
/// Notices: ECSS 8.3.2b: a search after a late boot counts from power-on, so that it toggles at once.
#[test]
fn reset_communication_keeps_bus_and_alternate_is_the_other_one() {
    let mut selector = following(PARAMETERS);
    selector.on_master(REDUNDANT, Heartbeat, ms(1_020));
    selector.start(ms(1_030));
    assert_eq!(selector.selected(), REDUNDANT);
    assert_eq!(decisions(&mut selector, 1_330), [(1_330, Selection::Toggled { to: NOMINAL })]);
}

/// Parameters are written over the bus at any time, also while the master is searched.
///
/// Verifies: ECSS 8.3.1c, 8.3.3i
/// Notices: ECSS 8.3.1c: an Ntoggle that is written during a search holds for the next one.
#[test]
fn a_search_ends_when_switching_is_disabled_meanwhile() {
    for disabled in [
        Parameters { ttoggle: 0, ..PARAMETERS },
        Parameters { ntoggle: 0, ..PARAMETERS },
        Parameters { consumer: span(0), ..PARAMETERS },
    ] {
        let mut selector = started(PARAMETERS);
        selector.configure(disabled);
        assert_eq!(selector.deadline(), None);
        assert_eq!(selector.poll(ms(10_000)), None);
        assert_eq!(selector.selected(), NOMINAL);
    }
}

/// Verifies: ECSS 8.3.2b, 8.3.1c
/// Notices: ECSS 8.3.2b: a write of a parameter ends the toggling.
/// Notices: ECSS 8.3.1c: a consumer time that is written during a search holds after the next change of the bus.
#[test]
fn toggling_time_shortened_in_search_switches_once_at_a_time() {
    let mut selector = started(PARAMETERS);
    selector.configure(Parameters { consumer: span(1), ..PARAMETERS });
    assert_eq!(selector.poll(ms(290)), Some(Selection::Toggled { to: REDUNDANT }));
    assert_eq!(selector.poll(ms(290)), None);
    assert_eq!(selector.deadline(), Some(ms(293)));
}

#[test]
fn equal_histories_make_equal_states() {
    let hash = |selector: &Selector| {
        let mut hasher = DefaultHasher::new();
        selector.hash(&mut hasher);
        hasher.finish()
    };
    let (a, mut b) = (following(PARAMETERS), following(PARAMETERS));
    assert_eq!((&a, hash(&a)), (&b, hash(&b)));
    b.poll(ms(1_100));
    assert_ne!(a, b);
}
