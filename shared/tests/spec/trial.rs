//! Slaves that are heard on the other bus only, fewer than the share that moves the master at once.
//!
//! Heartbeat 40 ms, consumer time 100 ms, Ttoggle 3: hold time 260 ms, settling time 380 ms. Silent share 50 %.
//!
//! Verifies: ECSS 8.3.3b

use ecss_can::redundancy::SwitchCause;
use ecss_can::redundancy::machine::{Action, Manager};

use crate::bench::{NOMINAL, REDUNDANT, ms, node};
use crate::manager::{decisions, hear, started, switched};

/// From `from` to before `to` slaves `here` are heard on the active bus and `there` on the other one, every 20 ms.
pub(crate) fn fly(
    manager: &mut Manager,
    from: u64,
    to: u64,
    here: &[u8],
    there: &[u8],
) -> Vec<(u64, Action)> {
    let mut done = vec![];
    for at in (from..to).step_by(20) {
        done.extend(decisions(manager, at));
        let active = manager.active();
        here.iter().for_each(|raw| _ = hear(manager, active, *raw, at));
        there.iter().for_each(|raw| _ = hear(manager, active.other(), *raw, at));
    }
    done.extend(decisions(manager, to));
    done.retain(|(_, action)| !matches!(action, Action::Lost(_)));
    done
}

/// Slaves 2 to 5 on the nominal bus until 1000 ms; then slave 5 is on the redundant one, and the master follows it.
fn tried() -> Manager {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &[2, 3, 4, 5], &[]), []);
    // Silent from 1080 ms on, heard there from 1000 ms on: the hold time ends at 1340 ms.
    let done = fly(&mut manager, 1_000, 1_340, &[2, 3, 4], &[5]);
    assert_eq!(done, [(1_340, switched(NOMINAL, SwitchCause::Tried))]);
    manager
}

#[test]
fn a_bus_where_more_slaves_are_heard_is_kept() {
    let mut manager = tried();
    assert_eq!(fly(&mut manager, 1_340, 5_000, &[2, 3, 4, 5], &[]), []);
    assert_eq!(manager.active(), REDUNDANT);
}

/// Given a try that was a success, when the bus is lost for a while and comes back, then it is tried again.
#[test]
fn a_bus_that_served_more_slaves_is_tried_again() {
    let mut manager = tried();
    assert_eq!(fly(&mut manager, 1_340, 3_000, &[2, 3, 4, 5], &[]), []);
    // Foreign load: no heartbeat gets through. All are silent from 3080 ms on.
    let done = fly(&mut manager, 3_000, 3_100, &[], &[]);
    assert_eq!(done, [(3_080, switched(REDUNDANT, SwitchCause::SlavesSilent))]);
    let done = fly(&mut manager, 3_100, 4_000, &[2, 3, 4], &[5]);
    let [(at, action)] = done[..] else { panic!("{done:?}") };
    assert_eq!(action, switched(NOMINAL, SwitchCause::Tried));
    // Not before the settling time; then the hold time at most.
    assert!((3_460..=3_080 + 380 + 260).contains(&at), "{at} ms");
    assert_eq!(fly(&mut manager, 4_000, 9_000, &[2, 3, 4, 5], &[]), []);
}

/// Given a try of the other bus, when it was in vain, then the heartbeat begins on the bus that the master returns to at once, not in
/// the rhythm of the one that it leaves.
///
/// Verifies: ECSS 8.3.3b.2, 8.3.3a, 8.3.3b.1
/// Notices: ECSS 8.3.3b.2: after a try in vain the heartbeat begins a period late.
#[test]
fn heartbeat_begins_at_once_after_a_try_in_vain() {
    let mut manager = tried();
    let mut beats = vec![];
    for at in (1_340..1_800).step_by(10) {
        while let Some(action) = manager.poll(ms(at)) {
            match action {
                Action::Switched { to, .. } => beats = vec![(at, to, false)],
                Action::Heartbeat { bus, .. } => beats.push((at, bus, true)),
                _ => {}
            }
        }
        if at % 20 == 0 {
            let active = manager.active();
            hear(&mut manager, active, 5, at);
            [2, 3, 4].iter().for_each(|raw| _ = hear(&mut manager, active.other(), *raw, at));
        }
    }
    let expected = [(1_720, NOMINAL, false), (1_720, NOMINAL, true), (1_760, NOMINAL, true)];
    assert_eq!(beats, expected);
}

/// Given a try that ended in a tie. When the slave left behind is heard on the other bus for the hold time, then that bus is
/// tried for it, and after this no bus is.
///
/// Verifies: ECSS 5.3.3.2.3k
/// Notices: ECSS 5.3.3.2.3k: the master changes the bus ever again for slaves behind a cut.
#[test]
fn after_a_tie_each_bus_was_tried_once() {
    let mut manager = tried();
    let done = fly(&mut manager, 1_340, 1_980, &[3, 4, 5], &[2]);
    assert_eq!(done, [(1_980, switched(REDUNDANT, SwitchCause::Tried))]);
    assert_eq!(fly(&mut manager, 1_980, 3_000, &[2, 3, 4], &[5]), []);
    assert_eq!(fly(&mut manager, 3_000, 20_000, &[2, 3, 4], &[5]), []);
    assert_eq!(manager.active(), NOMINAL);
}

/// Given a master that went to the other bus for a slave that was there for a while only, reset, say. Then it comes back for
/// the slave that it left behind.
#[test]
fn a_bus_that_serves_all_is_found_again_after_a_tie() {
    let mut manager = tried();
    let done = fly(&mut manager, 1_340, 1_980, &[3, 4, 5], &[2]);
    assert_eq!(done, [(1_980, switched(REDUNDANT, SwitchCause::Tried))]);
    assert_eq!(fly(&mut manager, 1_980, 20_000, &[2, 3, 4, 5], &[]), []);
}

/// Given a tie that another node caused: it sent the heartbeat of the master and kept slave 2 on the bus that was left. When
/// that node is silent, then the same try is made again.
#[test]
fn a_try_that_a_rival_disturbed_is_repeated() {
    let mut manager = tried();
    fly(&mut manager, 1_340, 1_500, &[3, 4, 5], &[2]);
    manager.on_rival();
    let done = fly(&mut manager, 1_500, 1_980, &[3, 4, 5], &[2]);
    assert_eq!(done, [(1_980, switched(REDUNDANT, SwitchCause::Tried))]);
    assert_eq!(fly(&mut manager, 1_980, 4_000, &[2, 3, 4], &[5]), [], "the rival is not silent yet");
    manager.on_rivals_silent(ms(4_000));
    let done = fly(&mut manager, 4_000, 4_020, &[2, 3, 4], &[5]);
    assert_eq!(done, [(4_000, switched(NOMINAL, SwitchCause::Tried))]);
    assert_eq!(fly(&mut manager, 4_020, 20_000, &[2, 3, 4, 5], &[]), []);
}

/// Given a tie without another node that sends the heartbeat of the master. When such a node comes later and is silent again,
/// then no try is repeated: one forged heartbeat does not change the bus.
#[test]
fn a_rival_after_a_try_does_not_repeat_it() {
    let mut manager = tried();
    let done = fly(&mut manager, 1_340, 1_980, &[3, 4, 5], &[2]);
    assert_eq!(done, [(1_980, switched(REDUNDANT, SwitchCause::Tried))]);
    assert_eq!(fly(&mut manager, 1_980, 4_000, &[2, 3, 4], &[5]), []);
    manager.on_rival();
    manager.on_rivals_silent(ms(4_000));
    assert_eq!(fly(&mut manager, 4_000, 20_000, &[2, 3, 4], &[5]), []);
}

#[test]
fn a_bus_where_fewer_slaves_are_heard_is_left_after_settling() {
    let mut manager = tried();
    let done = fly(&mut manager, 1_340, 1_760, &[4, 5], &[2, 3]);
    assert_eq!(done, [(1_720, switched(REDUNDANT, SwitchCause::TriedInVain))]);
    // As long as nothing else changes that was it.
    assert_eq!(fly(&mut manager, 1_760, 9_000, &[2, 3, 4], &[5]), []);
    // Slave 4 is lost as well: no more than half are, as on the other bus, but another slave has changed.
    let again = fly(&mut manager, 9_000, 9_500, &[2, 3], &[5]);
    assert_eq!(again[0], (9_080, switched(NOMINAL, SwitchCause::Tried)));
}

#[test]
fn another_slave_that_changes_allows_another_try() {
    let mut manager = started();
    let all = [2, 3, 4, 5, 6, 7, 8];
    assert_eq!(fly(&mut manager, 20, 1_000, &all, &[]), []);
    let done = fly(&mut manager, 1_000, 1_340, &[2, 3, 4, 5, 6, 7], &[8]);
    assert_eq!(done, [(1_340, switched(NOMINAL, SwitchCause::Tried))]);
    let done = fly(&mut manager, 1_340, 1_760, &[4, 5, 6, 7, 8], &[2, 3]);
    assert_eq!(done, [(1_720, switched(REDUNDANT, SwitchCause::TriedInVain))]);
    // The same slave comes and goes: it was tried for.
    assert_eq!(fly(&mut manager, 1_760, 3_000, &all, &[]), []);
    assert_eq!(fly(&mut manager, 3_000, 5_000, &[2, 3, 4, 5, 6, 7], &[8]), []);
    let done = fly(&mut manager, 5_000, 5_400, &[2, 3, 4, 5, 6], &[7, 8]);
    assert_eq!(
        done,
        [(5_080, switched(NOMINAL, SwitchCause::Tried))],
        "slave 7 is silent, slave 8 was held long ago"
    );
}

#[test]
fn a_slave_heard_nowhere_moves_nobody() {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &[2, 3, 4, 5], &[]), []);
    assert_eq!(fly(&mut manager, 1_000, 20_000, &[2, 3, 4], &[]), []);
}

#[test]
fn one_heartbeat_on_the_other_bus_is_no_reason() {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &[2, 3, 4, 5], &[]), []);
    assert_eq!(fly(&mut manager, 1_000, 1_200, &[2, 3, 4], &[]), []);
    assert_eq!(fly(&mut manager, 1_200, 1_220, &[2, 3, 4], &[5]), []);
    assert_eq!(fly(&mut manager, 1_220, 5_000, &[2, 3, 4], &[]), []);
}

#[test]
fn a_slave_that_is_back_within_its_search_moves_nobody() {
    let mut manager = started();
    assert_eq!(fly(&mut manager, 20, 1_000, &[2, 3, 4, 5], &[]), []);
    // Reset: it boots on the other bus and is back after Ttoggle consumer times.
    assert_eq!(fly(&mut manager, 1_000, 1_320, &[2, 3, 4], &[5]), []);
    assert_eq!(fly(&mut manager, 1_320, 5_000, &[2, 3, 4, 5], &[]), []);
}

#[test]
fn a_foreign_node_on_the_other_bus_moves_nobody() {
    let mut manager = started();
    manager.peers_mut().assign(node(9), false);
    assert_eq!(fly(&mut manager, 20, 5_000, &[2, 3, 4], &[9]), []);
}
