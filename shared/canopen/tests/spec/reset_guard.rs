//! The guard against babbled resets, with a pause of 500 ms (two consumer times of profile `standard`).

use async_canopen::nmt::machine::{ResetGuard, ResetVerdict};
use async_canopen::types::Duration;

use crate::bench::{ms, span};

const PAUSE: Duration = Duration::from_millis(500);

const FIRST: ResetVerdict = ResetVerdict::Ignore { is_first: true };
const FURTHER: ResetVerdict = ResetVerdict::Ignore { is_first: false };

/// A reset at `at` milliseconds; one that is obeyed leads to a boot 5 ms later.
fn reset(guard: &mut ResetGuard, at: u64) -> ResetVerdict {
    guard.poll(ms(at), PAUSE);
    let verdict = guard.on_reset(ms(at));
    if verdict == ResetVerdict::Obey {
        guard.obeyed();
        // The chip starts again: only the count is left.
        *guard = ResetGuard::new(guard.row());
        guard.on_boot(ms(at + 5));
    }
    verdict
}

/// Booted at zero, and then reset three times within 300 ms.
fn shut_guard() -> ResetGuard {
    let mut guard = ResetGuard::new(0);
    guard.on_boot(ms(0));
    for at in [100, 200, 300] {
        assert_eq!(reset(&mut guard, at), ResetVerdict::Obey);
    }
    guard
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5
#[test]
fn the_fourth_reset_in_a_row_is_ignored_and_reported_once() {
    let mut guard = shut_guard();
    assert_eq!(guard.row(), ResetGuard::MOST);
    assert_eq!(reset(&mut guard, 400), FIRST);
    assert_eq!(reset(&mut guard, 401), FURTHER);
    assert_eq!(reset(&mut guard, 402), FURTHER);
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5
/// Notices: ECSS 6.5.1a.4: resets before a heartbeat of the master count for ever.
/// Notices: ECSS 6.5.1a.5: resets before a heartbeat of the master count for ever.
#[test]
fn a_heartbeat_of_the_master_ends_the_row() {
    let mut guard = shut_guard();
    reset(&mut guard, 400);
    assert!(guard.on_heartbeat(), "a reset was ignored");
    assert!(!guard.on_heartbeat());
    assert_eq!((guard.row(), guard.deadline(PAUSE)), (0, None));
    // The first one follows a heartbeat and does not count; then three, and no fourth.
    for at in [500, 510, 520, 530] {
        assert_eq!(reset(&mut guard, at), ResetVerdict::Obey, "{at} ms");
    }
    assert_eq!(reset(&mut guard, 540), FIRST);
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5
#[test]
fn a_pause_without_a_reset_ends_the_row() {
    let mut guard = shut_guard();
    assert_eq!(guard.deadline(PAUSE), Some(ms(805)));
    assert!(!guard.poll(ms(804), PAUSE));
    assert_eq!(guard.row(), 3);
    assert!(!guard.poll(ms(805), PAUSE), "no reset was ignored");
    assert_eq!((guard.row(), guard.deadline(PAUSE)), (0, None));
    assert_eq!(reset(&mut guard, 806), ResetVerdict::Obey);
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5
#[test]
fn an_ignored_reset_begins_the_pause_anew() {
    let mut guard = shut_guard();
    for at in (350..5_000).step_by(499) {
        assert!(matches!(reset(&mut guard, at), ResetVerdict::Ignore { .. }), "{at} ms");
        assert_eq!(guard.deadline(PAUSE), Some(ms(at) + PAUSE));
    }
    let end = guard.deadline(PAUSE).unwrap();
    assert!(guard.poll(end, PAUSE), "resets were ignored");
    assert_eq!(guard.on_reset(end), ResetVerdict::Obey);
}

/// 20 resets without a heartbeat, each after the pause: 20 boot-ups.
///
/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5
#[test]
fn resets_with_a_pause_between_them_are_all_obeyed() {
    let mut guard = ResetGuard::new(0);
    guard.on_boot(ms(0));
    for number in 1..=20 {
        assert_eq!(reset(&mut guard, number * 505), ResetVerdict::Obey, "reset {number}");
        assert_eq!(guard.row(), 0);
    }
}

#[test]
fn the_row_goes_on_where_the_chip_was_reset() {
    let mut guard = ResetGuard::new(3);
    guard.on_boot(ms(0));
    assert_eq!(reset(&mut guard, 10), FIRST);
    // A count that no guard has stored is as good as the highest.
    let mut guard = ResetGuard::new(255);
    guard.on_boot(ms(0));
    assert_eq!(reset(&mut guard, 10), FIRST);
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5
#[test]
fn a_pause_of_zero_switches_the_guard_off() {
    let mut guard = ResetGuard::new(3);
    guard.on_boot(ms(0));
    for at in 0..10 {
        guard.poll(ms(at), span(0));
        assert_eq!(guard.on_reset(ms(at)), ResetVerdict::Obey);
        guard.on_boot(ms(at));
    }
}
