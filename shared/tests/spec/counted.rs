//! Who counts as a slave for the master's choice of the bus, and what it does while it hears none.
//!
//! Heartbeat 40 ms, consumer time 100 ms, Ttoggle 3, dwell 1000 ms.
//!
//! Verifies: ECSS 8.3.3b

use crate::instrument::{SLOW, STANDARD};
use ecss_can::profile::Profile;
use ecss_can::redundancy::machine::{Action, Manager};
use ecss_can::redundancy::{Parameters, SwitchCause};
use ecss_can::types::NmtState::{Initialising, Operational, PreOperational, Stopped};
use ecss_can::types::{Bus, NmtState};

use crate::bench::{NOMINAL, REDUNDANT, ms, node, span};
use crate::manager::{ALONE, GRACE, PARAMETERS, decisions, hear, started, switched, unassigned};

/// A heartbeat of a node that is not assigned.
fn word(manager: &mut Manager, bus: Bus, raw: u8, state: NmtState, at: u64) {
    manager.on_frame(bus, Some(node(raw)), ms(at));
    manager.on_heartbeat(bus, node(raw), state, ms(at));
}

/// The question is asked, and answered at `at`.
fn answer(manager: &mut Manager, raw: u8, at: u64) {
    assert_eq!(manager.peers_mut().take_unasked(), Some(node(raw)));
    manager.on_answer(node(raw), ms(at));
}

#[test]
fn silence_of_a_foreign_node_moves_nobody_and_it_is_forgotten() {
    let mut manager = unassigned();
    word(&mut manager, NOMINAL, 2, Operational, 10);
    answer(&mut manager, 2, 11);
    word(&mut manager, NOMINAL, 5, Operational, 20);
    let mut done = vec![];
    for at in (40..=1_100).step_by(40) {
        done.extend(decisions(&mut manager, at));
        word(&mut manager, NOMINAL, 2, Operational, at);
    }
    // Ten consumer times after its last word.
    assert_eq!(done, [(120, Action::Lost(node(5))), (1_020, Action::Forgotten(node(5)))]);
    assert_eq!(manager.peers().state(node(5)), None);
}

#[test]
fn a_foreign_node_does_not_keep_the_master_from_alternating() {
    let mut manager = unassigned();
    let mut done = vec![];
    for at in (10..=2_100).step_by(40) {
        done.extend(decisions(&mut manager, at));
        word(&mut manager, NOMINAL, 5, PreOperational, at);
    }
    let unheard = |from| switched(from, SwitchCause::Unheard);
    assert_eq!(done, [(1_000, unheard(NOMINAL)), (2_000, unheard(REDUNDANT))]);
}

#[test]
fn a_foreign_node_heard_is_no_reason_for_isolation() {
    let mut manager = unassigned();
    word(&mut manager, NOMINAL, 5, Operational, 10);
    manager.on_health(NOMINAL, ALONE, false, ms(20));
    assert_eq!(decisions(&mut manager, 90), []);
    // One that answered is.
    answer(&mut manager, 5, 91);
    assert_eq!(decisions(&mut manager, 95), [(93, switched(NOMINAL, SwitchCause::Isolated))]);
}

#[test]
fn a_slave_that_counts_stays_when_it_is_silent() {
    let mut manager = unassigned();
    word(&mut manager, NOMINAL, 2, Operational, 10);
    answer(&mut manager, 2, 11);
    let done = decisions(&mut manager, 5_000);
    assert_eq!(
        done[..2],
        [(110, Action::Lost(node(2))), (110, switched(NOMINAL, SwitchCause::SlavesSilent))]
    );
    assert!(done.iter().all(|(_, action)| !matches!(action, Action::Forgotten(_))), "{done:?}");
}

/// Given three slaves that answered and one of them silent, When another one boots up and is silent then, Then it still
/// counts: two of three are silent, and the master leaves the bus.
#[test]
fn a_slave_that_boots_up_beside_a_lost_one_counts() {
    let mut manager = unassigned();
    for raw in [2, 3, 9] {
        word(&mut manager, NOMINAL, raw, Operational, 10);
        answer(&mut manager, raw, 11);
    }
    let mut done = vec![];
    for at in (40..=400).step_by(40) {
        done.extend(decisions(&mut manager, at));
        if at == 240 {
            word(&mut manager, NOMINAL, 2, Initialising, at);
            manager.peers_mut().recheck(ms(at));
        } else if at < 240 {
            word(&mut manager, NOMINAL, 2, Operational, at);
        }
        word(&mut manager, NOMINAL, 3, Operational, at);
    }
    assert_eq!(
        done,
        [
            (110, Action::Lost(node(9))),
            (340, Action::Lost(node(2))),
            (340, switched(NOMINAL, SwitchCause::SlavesSilent))
        ]
    );
}

/// Given three slaves that answered, When one is reset and its boot-up message comes on the other bus only, Then the master
/// tries that bus after the hold time of 260 ms: a boot-up message makes no foreign node of a slave.
#[test]
fn a_slave_that_boots_up_on_the_other_bus_still_counts() {
    let mut manager = unassigned();
    for raw in [2, 3, 9] {
        word(&mut manager, NOMINAL, raw, Operational, 10);
        answer(&mut manager, raw, 11);
    }
    let mut done = vec![];
    for at in (40..=500).step_by(20) {
        done.extend(decisions(&mut manager, at));
        [2, 3].into_iter().for_each(|raw| word(&mut manager, NOMINAL, raw, Operational, at));
        match at {
            200 => word(&mut manager, REDUNDANT, 9, Initialising, at),
            220.. => word(&mut manager, REDUNDANT, 9, PreOperational, at),
            _ => {}
        }
    }
    let tried = switched(NOMINAL, SwitchCause::Tried);
    assert_eq!(done, [(110, Action::Lost(node(9))), (460, tried)]);
}

/// Given a slave that answered and booted up since, When it is silent on both buses for ten consumer times, Then it is
/// forgotten: that boot-up message may have been the last word of another node.
#[test]
fn a_slave_that_booted_up_and_did_not_answer_is_forgotten() {
    let mut manager = unassigned();
    for raw in [2, 3] {
        word(&mut manager, NOMINAL, raw, Operational, 10);
        answer(&mut manager, raw, 11);
    }
    word(&mut manager, NOMINAL, 3, Initialising, 20);
    let mut done = vec![];
    for at in (40..=1_300).step_by(40) {
        done.extend(decisions(&mut manager, at));
        word(&mut manager, NOMINAL, 2, Operational, at);
        word(&mut manager, REDUNDANT, 2, Operational, at);
    }
    let forgotten: Vec<_> =
        done.iter().filter(|(_, action)| matches!(action, Action::Forgotten(_))).collect();
    assert_eq!(forgotten, [&(1_020, Action::Forgotten(node(3)))]);
    assert!(!manager.peers().counts(node(3)));
}

#[test]
fn a_node_that_answered_is_asked_again_after_its_boot_up() {
    let mut manager = unassigned();
    let asked = |manager: &mut Manager| manager.peers_mut().take_unasked();
    word(&mut manager, NOMINAL, 5, Initialising, 1);
    assert_eq!(asked(&mut manager), None, "it does not serve SDOs yet");
    word(&mut manager, REDUNDANT, 5, PreOperational, 2);
    assert_eq!(asked(&mut manager), None, "it is not on the active bus");
    word(&mut manager, NOMINAL, 5, Stopped, 3);
    assert_eq!(asked(&mut manager), None, "it does not serve SDOs");
    word(&mut manager, NOMINAL, 5, PreOperational, 4);
    assert_eq!(asked(&mut manager), Some(node(5)));
    word(&mut manager, NOMINAL, 5, Operational, 5);
    assert_eq!(asked(&mut manager), None);
    manager.on_answer(node(5), ms(6));
    assert!(manager.peers().counts(node(5)));

    word(&mut manager, NOMINAL, 5, Initialising, 7);
    assert!(manager.peers().counts(node(5)), "a reset is no reason to ignore it");
    word(&mut manager, NOMINAL, 5, PreOperational, 8);
    assert_eq!(asked(&mut manager), Some(node(5)));
}

/// Node `raw` is heard Operational, as a slave of another master.
fn overhear(manager: &mut Manager, raw: u8) {
    word(manager, NOMINAL, raw, Operational, 10);
    manager.peers_mut().on_overheard(node(raw));
}

/// Given slaves of the master that was active before, When this one takes over, Then those that it has heard count. A slave that is
/// heard and does not answer this master no longer counts.
#[test]
fn overheard_slaves_count_after_takeover_until_no_answer() {
    let mut manager = unassigned();
    overhear(&mut manager, 2);
    word(&mut manager, NOMINAL, 3, PreOperational, 10);
    manager.peers_mut().on_overheard(node(7));
    assert!(!manager.peers().counts(node(2)));
    manager.take_over(NOMINAL, 1, ms(20));
    let counted = |manager: &Manager| [2, 3, 7].map(|raw| manager.peers().counts(node(raw)));
    assert_eq!(counted(&manager), [true, false, false], "3 was not started, 7 never heard");
    let mut no_answer = |at| {
        word(&mut manager, NOMINAL, 2, Operational, at - 10);
        let is_unknown = manager.peers_mut().on_no_answer(node(2), ms(at));
        (is_unknown, counted(&manager))
    };
    let counts = [true, false, false];
    assert_eq!([500, 1_500].map(&mut no_answer), [(false, counts); 2]);
    assert_eq!(no_answer(2_500), (true, [false; 3]));
}

/// Given a standby that heard slaves Operational, When it takes over, Then they count, unless they are more than the active master
/// ever claimed: then one of them is a foreign node. What it heard before it was active counts no second time.
#[test]
fn slaves_heard_operational_are_those_of_the_active_master() {
    for (claimed, are_counted) in [(0, false), (2, false), (3, true), (4, true)] {
        let mut manager = unassigned();
        [2, 5, 127].into_iter().for_each(|raw| overhear(&mut manager, raw));
        manager.take_over(NOMINAL, claimed, ms(20));
        assert_eq!([2, 5, 127].map(|raw| manager.peers().counts(node(raw))), [are_counted; 3], "{claimed}");
        manager.take_over(NOMINAL, 4, ms(30));
        assert_eq!([2, 5, 127].map(|raw| manager.peers().counts(node(raw))), [are_counted; 3], "{claimed}");
    }
}

/// Given an overheard slave that is silent here, When the third question has no answer, Then it still counts: it may be cut off.
#[test]
fn an_overheard_slave_that_is_silent_counts_without_an_answer() {
    let mut manager = unassigned();
    overhear(&mut manager, 2);
    manager.take_over(NOMINAL, 1, ms(20));
    for at in [500, 1_500, 2_500] {
        assert!(!manager.peers_mut().on_no_answer(node(2), ms(at)));
    }
    assert!(manager.peers().counts(node(2)));
}

#[test]
fn an_assigned_slave_counts_unasked_until_it_is_removed() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 10);
    assert_eq!(manager.peers_mut().take_unasked(), None);
    assert!(manager.peers().counts(node(2)));
    manager.peers_mut().assign(node(2), false);
    assert!(!manager.peers().counts(node(2)));
    assert_eq!(decisions(&mut manager, 500), [], "its silence is of no interest");
    // When it is heard again it is new.
    word(&mut manager, NOMINAL, 2, Operational, 510);
    answer(&mut manager, 2, 511);
    assert!(manager.peers().counts(node(2)));
}

#[test]
fn assigned_slaves_never_heard_are_reported_after_two_dwells() {
    let mut manager = unassigned();
    for raw in [2, 3, 4] {
        manager.peers_mut().assign(node(raw), true);
    }
    let mut reported = vec![];
    for at in (40..=6_000).step_by(40) {
        while let Some(action) = manager.poll(ms(at)) {
            reported.extend(matches!(action, Action::Unheard(_)).then_some((at, action)));
        }
        hear(&mut manager, NOMINAL, 3, at);
    }
    assert_eq!(reported, [(2_000, Action::Unheard(node(2))), (2_000, Action::Unheard(node(4)))]);
}

#[test]
fn a_slave_heard_on_the_other_bus_holds_the_dwell_too() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 3, 10);
    for at in (40..=3_000).step_by(40) {
        let done = decisions(&mut manager, at);
        assert!(
            done.iter().all(|(_, action)| *action != switched(NOMINAL, SwitchCause::Unheard)),
            "{done:?}"
        );
        hear(&mut manager, NOMINAL, 3, at);
        hear(&mut manager, REDUNDANT, 4, at);
    }
}

#[test]
fn a_dwell_covers_the_search_of_a_slave() {
    // Twice Ttoggle consumer times and two heartbeat periods, and no less than asked for.
    assert_eq!(PARAMETERS.dwell(span(0)), span(2 * 300 + 2 * 40));
    assert_eq!(SLOW.redundancy().dwell(SLOW.dwell), span(25_500));
    assert_eq!(STANDARD.redundancy().dwell(STANDARD.dwell), span(10_000));
    assert_eq!(STANDARD.redundancy().search_time(), span(25_500));
    assert_eq!(SLOW.redundancy().search_time(), span(137_500));
}

#[test]
fn a_selective_slave_must_search_for_two_dwells() {
    assert!(STANDARD.is_search_long_enough() && SLOW.is_search_long_enough());
    let selective = Profile { selective: SLOW.selective, ..STANDARD };
    assert!(selective.is_search_long_enough());
    // 2 x 250 ms x 40 = 20 s: two dwells. One toggle less is too short, for selective slaves alone.
    assert!(Profile { ntoggle: 39, ..selective }.is_search_long_enough());
    assert!(!Profile { ntoggle: 38, ..selective }.is_search_long_enough());
    assert!(Profile { ntoggle: 38, ..STANDARD }.is_search_long_enough());
}

#[test]
fn without_monitoring_the_master_stays() {
    let mut manager = Manager::new(Parameters { consumer: span(0), ..PARAMETERS }, 50, span(1_000), GRACE);
    manager.start(ms(0));
    assert_eq!(decisions(&mut manager, 60_000), []);
}

/// Given a node that does not count and has become silent on the active bus, When it is heard on the other bus, Then this
/// alone makes nothing due.
#[test]
fn a_foreign_node_heard_on_the_other_bus_makes_nothing_due() {
    let mut manager = unassigned();
    for at in (10..=990).step_by(20) {
        decisions(&mut manager, at);
        word(&mut manager, REDUNDANT, 5, Operational, at);
        assert!(manager.deadline().is_some_and(|due| due > ms(at)), "{at} ms");
    }
}

/// Given a foreign node that is known, When it is assigned, Then its silence counts at once.
#[test]
fn a_foreign_node_that_is_assigned_is_judged_at_once() {
    let mut manager = unassigned();
    word(&mut manager, REDUNDANT, 5, Operational, 10);
    decisions(&mut manager, 20);
    manager.peers_mut().assign(node(5), true);
    assert!(manager.deadline().is_some_and(|due| due <= ms(20)));
}
