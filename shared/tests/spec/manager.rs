//! Bus management of the master.
//!
//! Heartbeat 40 ms, consumer time 100 ms, Ttoggle 3: settling time 380 ms. Silent share 50 %. Nodes 2 to 127 are
//! assigned.
//!
//! Verifies: ECSS 8.3.3b

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::nmt::Target;
use ecss_can::redundancy::machine::{Action, Manager, PeerHeartbeat};
use ecss_can::redundancy::{Parameters, SwitchCause};
use ecss_can::types::NmtState::{Initialising, Operational, PreOperational, Stopped};
use ecss_can::types::{Bus, Duration, Frame};

use crate::bench::{NOMINAL, REDUNDANT, frame, ms, node};

pub(crate) const PARAMETERS: Parameters = Parameters {
    consumer: Duration::from_millis(100),
    producer: Duration::from_millis(40),
    bdefault: Bus::Nominal,
    ttoggle: 3,
    ntoggle: 4,
    ctoggle: 0,
};

pub(crate) const ALONE: Health =
    Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };

/// Longer than two toggling times and two heartbeat periods, 680 ms.
const DWELL: Duration = Duration::from_millis(1_000);
/// Two frames and the error frame between them.
pub(crate) const GRACE: Duration = Duration::from_millis(2);

pub(crate) fn started() -> Manager {
    let mut manager = unassigned();
    for raw in 2..=127 {
        manager.peers_mut().assign(node(raw), true);
    }
    manager
}

pub(crate) fn unassigned() -> Manager {
    let mut manager = Manager::new(PARAMETERS, 50, DWELL, GRACE);
    manager.start(ms(0));
    manager
}

fn heartbeat() -> Frame {
    frame(0x701, &[0x05])
}

/// Every action up to `until`, with its time.
fn actions(manager: &mut Manager, until: u64) -> Vec<(u64, Action)> {
    let mut done = vec![];
    while let Some(at) = manager.deadline().filter(|at| *at <= ms(until)) {
        while let Some(action) = manager.poll(at) {
            done.push((at.as_micros() / 1_000, action));
        }
    }
    done
}

/// The same without heartbeats and reports of slaves that were never heard.
pub(crate) fn decisions(manager: &mut Manager, until: u64) -> Vec<(u64, Action)> {
    let mut all = actions(manager, until);
    all.retain(|(_, action)| !matches!(action, Action::Heartbeat { .. } | Action::Unheard(_)));
    all
}

pub(crate) fn hear(manager: &mut Manager, bus: Bus, raw: u8, at: u64) -> PeerHeartbeat {
    manager.on_frame(bus, Some(node(raw)), ms(at));
    manager.on_heartbeat(bus, node(raw), Operational, ms(at))
}

pub(crate) fn switched(from: Bus, cause: SwitchCause) -> Action {
    Action::Switched { from, to: from.other(), cause }
}

/// Verifies: ECSS 8.3.3a
#[test]
fn heartbeats_on_the_active_bus_every_period() {
    let mut manager = started();
    let beat = Action::Heartbeat { bus: NOMINAL, frame: heartbeat() };
    assert_eq!(actions(&mut manager, 80), [(0, beat), (40, beat), (80, beat)]);
}

/// Verifies: ECSS 8.3.3b.1, 8.3.3b.2, 8.3.3a
/// Notices: ECSS 8.3.3b.2: the heartbeat keeps its rhythm: on the other bus it is late.
/// Notices: ECSS 8.3.3b.2: after a second switch in the settling time the heartbeat keeps its rhythm.
#[test]
fn commanded_switch_stops_heartbeat_here_and_starts_it_there() {
    let mut manager = started();
    actions(&mut manager, 50);
    manager.request(REDUNDANT);
    assert_eq!(manager.poll(ms(50)), Some(switched(NOMINAL, SwitchCause::Commanded)));
    let beat = Action::Heartbeat { bus: REDUNDANT, frame: heartbeat() };
    assert_eq!(manager.poll(ms(50)), Some(beat));
    assert_eq!(actions(&mut manager, 130), [(90, beat), (130, beat)]);
    // Back in the settling time, and not in the rhythm of 130 ms.
    manager.request(NOMINAL);
    assert_eq!(manager.poll(ms(140)), Some(switched(REDUNDANT, SwitchCause::Commanded)));
    let beat = Action::Heartbeat { bus: NOMINAL, frame: heartbeat() };
    assert_eq!(actions(&mut manager, 180), [(140, beat), (180, beat)]);
}

/// Given a bus that fails 10 ms after a heartbeat, then the next one is on the other bus at once, and every 40 ms from then on.
///
/// Verifies: ECSS 8.3.3b.1, 8.3.3b.2, 8.3.3a
/// Notices: ECSS 8.3.3b.2: after bus-off the heartbeat on the other bus begins a period late.
#[test]
fn failure_of_a_bus_starts_the_heartbeat_on_the_other_one_at_once() {
    let mut manager = started();
    actions(&mut manager, 50);
    let off = Health { state: ErrorState::BusOff, ..Health::default() };
    manager.on_health(NOMINAL, off, true, ms(50));
    assert_eq!(manager.poll(ms(50)), Some(switched(NOMINAL, SwitchCause::BusOff)));
    let beat = Action::Heartbeat { bus: REDUNDANT, frame: heartbeat() };
    assert_eq!(actions(&mut manager, 130), [(50, beat), (90, beat), (130, beat)]);
}

/// Given no acknowledgement on either bus, when the master changes the bus by command, then its heartbeat is on the other one at
/// once, and every 40 ms from then on.
///
/// Verifies: ECSS 8.3.3b.2, 8.3.3a
/// Notices: ECSS 8.3.3b.2: the heartbeat does not start on a bus without acknowledgement.
#[test]
fn switch_to_a_bus_without_acknowledgement_starts_heartbeats() {
    let mut manager = started();
    actions(&mut manager, 50);
    let alone = Health { state: ErrorState::Passive, last_error: LastError::Ack, ..Health::default() };
    for bus in Bus::ALL {
        manager.on_health(bus, alone, false, ms(50));
    }
    manager.request(REDUNDANT);
    assert_eq!(manager.poll(ms(50)), Some(switched(NOMINAL, SwitchCause::Commanded)));
    let beat = Action::Heartbeat { bus: REDUNDANT, frame: heartbeat() };
    assert_eq!(actions(&mut manager, 130), [(50, beat), (90, beat), (130, beat)]);
}

#[test]
fn a_switch_to_the_active_bus_is_none() {
    let mut manager = started();
    actions(&mut manager, 10);
    manager.request(NOMINAL);
    assert_eq!(manager.poll(ms(10)), None);
}

/// Notices: ECSS 8.3.3b: a late heartbeat on the old bus announces the new one.
#[test]
fn new_bus_is_announced_once_its_heartbeat_was_sent_or_failed() {
    for failed in [false, true] {
        let mut manager = started();
        actions(&mut manager, 0);
        assert!(manager.is_announced());
        manager.request(REDUNDANT);
        actions(&mut manager, 50);
        manager.poll(ms(50));
        assert!(!manager.is_announced());
        // That of the old bus does not count.
        manager.on_heartbeat_sent(NOMINAL, ms(50));
        manager.on_heartbeat_failed(NOMINAL);
        assert!(!manager.is_announced());
        if failed {
            manager.on_heartbeat_failed(REDUNDANT);
        } else {
            manager.on_heartbeat_sent(REDUNDANT, ms(51));
        }
        assert!(manager.is_announced());
    }
}

/// Verifies: ECSS 8.3.3b.2
#[test]
fn late_heartbeat_on_old_bus_is_followed_by_one_on_active_bus() {
    let mut manager = started();
    actions(&mut manager, 0);
    manager.request(REDUNDANT);
    while manager.poll(ms(20)).is_some() {}
    manager.on_heartbeat_sent(NOMINAL, ms(21));
    assert_eq!(manager.poll(ms(21)), Some(Action::Heartbeat { bus: REDUNDANT, frame: heartbeat() }));
}

#[test]
fn a_master_that_hears_no_slave_alternates_every_dwell() {
    for acknowledged in [true, false] {
        let mut manager = started();
        if !acknowledged {
            manager.on_health(NOMINAL, ALONE, false, ms(3));
        }
        let unheard = |from| switched(from, SwitchCause::Unheard);
        let expected = [(1_000, unheard(NOMINAL)), (2_000, unheard(REDUNDANT)), (3_000, unheard(NOMINAL))];
        assert_eq!(decisions(&mut manager, 3_500), expected, "acknowledged: {acknowledged}");
    }
}

#[test]
fn isolated_where_a_slave_was_heard_it_switches_within_5_ms() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 30);
    manager.on_health(NOMINAL, ALONE, false, ms(83));
    assert_eq!(decisions(&mut manager, 88), [(85, switched(NOMINAL, SwitchCause::Isolated))]);
}

/// Verifies: ECSS 5.3.3.2.3h, 5.3.3.2.3j, 5.3.3.2.3k, 5.3.3.2.3k.1, 5.3.3.2.3k.2
/// Notices: ECSS 5.3.3.2.3h: a bus that is acknowledged again is left as isolated.
/// Notices: ECSS 5.3.3.2.3k: a bus that is acknowledged again is left as isolated.
/// Notices: ECSS 5.3.3.2.3k.1: acknowledged frames do not end the isolation of a master.
/// Notices: ECSS 5.3.3.2.3k.2: a bus that is acknowledged again is left as isolated.
/// Notices: ECSS 5.3.3.2.3j: a bus that is acknowledged again is left as isolated.
#[test]
fn reception_or_an_acknowledge_is_no_isolation() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 30);
    manager.on_health(NOMINAL, ALONE, false, ms(50));
    hear(&mut manager, NOMINAL, 2, 51);
    assert_eq!(decisions(&mut manager, 52), []);
    manager.on_sent(NOMINAL, ms(52));
    assert_eq!(decisions(&mut manager, 53), []);
    manager.on_health(NOMINAL, Health::default(), false, ms(53));
    assert_eq!(decisions(&mut manager, 90), []);
}

#[test]
fn error_passive_for_another_reason_is_no_isolation() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 30);
    manager.on_health(NOMINAL, Health { last_error: LastError::BitDominant, ..ALONE }, false, ms(50));
    assert_eq!(decisions(&mut manager, 90), []);
}

#[test]
fn after_switch_isolation_waits_for_settling_and_a_heard_slave() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 30);
    manager.on_health(REDUNDANT, ALONE, false, ms(40));
    manager.request(REDUNDANT);
    assert_eq!(manager.poll(ms(50)), Some(switched(NOMINAL, SwitchCause::Commanded)));
    // The slave is heard on the new bus until 400 ms; still nobody acknowledges.
    for at in (100..=400).step_by(50) {
        assert_eq!(decisions(&mut manager, at), []);
        hear(&mut manager, REDUNDANT, 2, at);
    }
    assert_eq!(decisions(&mut manager, 450), [(430, switched(REDUNDANT, SwitchCause::Isolated))]);
}

/// Given a bus that was left because its controller went bus-off too often, when the other bus fails, then the master returns as soon
/// as the controller of the first bus has recovered, and not before.
///
/// Verifies: ECSS 5.3.3.2.3e, 5.3.3.2.3i
/// Notices: ECSS 5.3.3.2.3e: a bus that failed once is never used again.
/// Notices: ECSS 5.3.3.2.3i: the failed bus is compared with itself and is not left.
#[test]
fn a_failed_bus_is_left_unless_the_other_is_failed_too() {
    let off = Health { state: ErrorState::BusOff, ..Health::default() };
    let mut manager = started();
    manager.on_health(NOMINAL, off, false, ms(10));
    assert_eq!(decisions(&mut manager, 10), []);
    manager.on_health(NOMINAL, off, true, ms(11));
    assert_eq!(manager.poll(ms(11)), Some(switched(NOMINAL, SwitchCause::BusOff)));
    manager.on_health(REDUNDANT, off, true, ms(12));
    assert_eq!(decisions(&mut manager, 20), []);
    manager.on_health(NOMINAL, Health::default(), false, ms(30));
    assert_eq!(manager.poll(ms(30)), Some(switched(REDUNDANT, SwitchCause::BusOff)));
}

/// Verifies: ECSS 6.5.2a
#[test]
fn a_slave_is_lost_once_and_returns_once() {
    let mut manager = started();
    for raw in 2..=4 {
        hear(&mut manager, NOMINAL, raw, 10);
    }
    for raw in 3..=4 {
        hear(&mut manager, NOMINAL, raw, 90);
        hear(&mut manager, NOMINAL, raw, 160);
    }
    assert_eq!(decisions(&mut manager, 200), [(110, Action::Lost(node(2)))]);
    assert_eq!(manager.peers().state(node(2)), None);
    let heard = hear(&mut manager, NOMINAL, 2, 201);
    assert_eq!(heard, PeerHeartbeat { changed: false, returned: true, start: false });
    assert!(!hear(&mut manager, NOMINAL, 2, 202).returned);
    assert_eq!(manager.peers().state(node(2)), Some(Operational));
}

/// Verifies: ECSS 6.5.2a
/// Notices: ECSS 6.5.2a: the master monitors 125 slaves at most.
#[test]
fn up_to_126_slaves_are_monitored() {
    let mut manager = started();
    for raw in 2..=127 {
        assert!(hear(&mut manager, NOMINAL, raw, 10).changed);
    }
    let lost = decisions(&mut manager, 110);
    assert_eq!(lost.iter().filter(|(_, action)| matches!(action, Action::Lost(_))).count(), 126);
    assert_eq!(lost.last(), Some(&(110, switched(NOMINAL, SwitchCause::SlavesSilent))));
}

#[test]
fn half_of_the_slaves_silent_is_enough_less_is_not() {
    let mut manager = started();
    for raw in 2..=5 {
        hear(&mut manager, NOMINAL, raw, 10);
    }
    for raw in 3..=5 {
        hear(&mut manager, NOMINAL, raw, 90);
    }
    assert_eq!(decisions(&mut manager, 150), [(110, Action::Lost(node(2)))]);
    for raw in 4..=5 {
        hear(&mut manager, NOMINAL, raw, 150);
    }
    assert_eq!(
        decisions(&mut manager, 200),
        [(190, Action::Lost(node(3))), (190, switched(NOMINAL, SwitchCause::SlavesSilent))]
    );
}

/// Given a bus that was left because half of its slaves fell silent, when as many are silent on the other one, then the master
/// stays there, and the nodes that resumed there go on.
///
/// Verifies: ECSS 5.3.3.2.3h, 5.3.3.2.2b
/// Notices: ECSS 5.3.3.2.3h: slaves that are silent on both buses make the master leave each.
/// Notices: ECSS 5.3.3.2.2b: with one of two slaves without power the master changes the bus again and again.
#[test]
fn equal_halves_of_slaves_on_both_buses_keep_the_present_bus() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 10);
    hear(&mut manager, NOMINAL, 3, 10);
    hear(&mut manager, NOMINAL, 3, 60);
    let left = decisions(&mut manager, 110);
    assert_eq!(left.last(), Some(&(110, switched(NOMINAL, SwitchCause::SlavesSilent))));
    // On the other bus slave 3 follows, slave 2 is heard as little as before.
    for at in (150..2_000).step_by(50) {
        assert_eq!(decisions(&mut manager, at), []);
        hear(&mut manager, REDUNDANT, 3, at);
    }
}

/// Given a master that hears its slaves on the active bus, when no node acknowledges its frames on the other bus, then the master stays.
///
/// Verifies: ECSS 5.3.3.2.2a
/// Notices: ECSS 5.3.3.2.2a: a master off the other bus leaves the active one.
#[test]
fn a_master_off_the_other_bus_stays() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 10);
    manager.on_health(REDUNDANT, ALONE, false, ms(20));
    assert_eq!(decisions(&mut manager, 100), []);
}

/// Given a bus that was left for silence, and slaves that were heard on the other one since, when those are silent as well, then
/// the master leaves as fast as the first time.
///
/// Verifies: ECSS 5.3.3.2.3h
/// Notices: ECSS 5.3.3.2.3h: slaves that were silent in an earlier fault are never forgotten.
#[test]
fn the_next_fault_is_answered_as_the_first_one() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 10);
    let left = decisions(&mut manager, 110);
    assert_eq!(left.last(), Some(&(110, switched(NOMINAL, SwitchCause::SlavesSilent))));
    for at in (150..=700).step_by(50) {
        assert_eq!(decisions(&mut manager, at), []);
        hear(&mut manager, REDUNDANT, 2, at);
    }
    let left = decisions(&mut manager, 800);
    assert_eq!(left.last(), Some(&(800, switched(REDUNDANT, SwitchCause::SlavesSilent))));
}

/// Verifies: ECSS 5.3.3.2.3e
/// Notices: ECSS 5.3.3.2.3e: a master that hears no slave stays on the bus for a whole dwell time.
#[test]
fn with_all_slaves_silent_master_leaves_at_once_and_every_dwell() {
    let mut manager = started();
    hear(&mut manager, NOMINAL, 2, 10);
    let silent = |from| switched(from, SwitchCause::SlavesSilent);
    let unheard = |from| switched(from, SwitchCause::Unheard);
    assert_eq!(
        decisions(&mut manager, 2_500),
        [
            (110, Action::Lost(node(2))),
            (110, silent(NOMINAL)),
            (1_110, unheard(REDUNDANT)),
            (2_110, unheard(NOMINAL))
        ]
    );
}

#[test]
fn slaves_heard_only_on_other_bus_draw_master_after_settling() {
    let mut manager = started();
    // Given a master that was reset while its slaves were on the redundant bus, and the nominal one is cut
    for at in (10..390).step_by(40) {
        assert_eq!(decisions(&mut manager, at), []);
        hear(&mut manager, REDUNDANT, 2, at);
    }
    // Then it goes where they are
    assert_eq!(decisions(&mut manager, 390), [(390, switched(NOMINAL, SwitchCause::SlavesSilent))]);
}

/// Verifies: ECSS 8.3.3f
/// Notices: ECSS 8.3.3f: a slave is started only at the heartbeat that reports a new state.
#[test]
fn waiting_slaves_are_to_be_started_on_active_bus_unless_held() {
    let mut manager = started();
    let start = |manager: &mut Manager, bus, state| manager.on_heartbeat(bus, node(2), state, ms(1)).start;
    assert!(start(&mut manager, NOMINAL, PreOperational));
    assert!(start(&mut manager, NOMINAL, Initialising));
    assert!(!start(&mut manager, NOMINAL, Operational));
    assert!(!start(&mut manager, REDUNDANT, PreOperational));
    manager.peers_mut().hold(Target::Node(node(2)), true);
    assert!(!start(&mut manager, NOMINAL, PreOperational));
    manager.peers_mut().hold(Target::All, false);
    assert!(start(&mut manager, NOMINAL, PreOperational));
}

/// Given a slave that runs. When somebody else stops it, then it is started again, unless the application holds it.
#[test]
fn a_stopped_slave_that_is_not_held_is_to_be_started() {
    let mut manager = started();
    let start = |manager: &mut Manager, state| manager.on_heartbeat(NOMINAL, node(2), state, ms(1)).start;
    assert!(!start(&mut manager, Operational));
    assert!(start(&mut manager, Stopped));
    manager.peers_mut().hold(Target::Node(node(2)), true);
    assert!(!start(&mut manager, Stopped));
}

/// Verifies: ECSS 8.3.3f
/// Notices: ECSS 8.3.3f: a slave that the application released is not started.
#[test]
fn slaves_held_before_they_were_heard_are_not_started_either() {
    let mut manager = started();
    let start =
        |manager: &mut Manager, raw| manager.on_heartbeat(NOMINAL, node(raw), Initialising, ms(1)).start;
    manager.peers_mut().hold(Target::All, true);
    assert!(!start(&mut manager, 2) && !start(&mut manager, 127));
    manager.peers_mut().hold(Target::Node(node(127)), false);
    assert!(!start(&mut manager, 2) && start(&mut manager, 127));
    manager.peers_mut().hold(Target::Node(node(3)), true);
    manager.peers_mut().hold(Target::All, false);
    assert!(start(&mut manager, 2) && start(&mut manager, 3));
}

#[test]
fn a_change_of_state_is_news() {
    let mut manager = started();
    let mut changed = |state, at| manager.on_heartbeat(NOMINAL, node(2), state, ms(at)).changed;
    assert!(changed(Initialising, 1));
    assert!(changed(PreOperational, 2));
    assert!(!changed(PreOperational, 3));
    assert!(changed(Operational, 4));
}
