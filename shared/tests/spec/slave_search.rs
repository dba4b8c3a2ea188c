//! Ttoggle, Ntoggle and Ctoggle of the master (ECSS Table 8-2): how often it changes the bus while it hears no slave.
//!
//! Heartbeat 40 ms, consumer time 100 ms, Ttoggle 3, Ntoggle 4, dwell 1,000 ms, unless a test says otherwise.
//!
//! Verifies: ECSS 8.3.1b, 8.3.1c, 8.3.3b

use ecss_can::redundancy::machine::{Action, Manager};
use ecss_can::redundancy::{Parameters, SwitchCause};
use ecss_can::types::{Bus, Duration, NodeId};

use crate::bench::{NOMINAL, REDUNDANT, ms, node};
use crate::manager::{ALONE, GRACE, PARAMETERS, decisions, hear, switched};

/// A master with slave 2 assigned, at power-on.
fn started(parameters: Parameters) -> Manager {
    let mut manager: Manager = Manager::new(parameters, 50, Duration::from_millis(1_000), GRACE);
    manager.peers_mut().assign(node(2), true);
    manager.start(ms(0));
    manager
}

fn ctoggle(manager: &Manager) -> u8 {
    manager.parameters().ctoggle
}

fn unheard(from: Bus) -> Action {
    switched(from, SwitchCause::Unheard)
}

/// Given Ntoggle 4, When no slave is heard, Then the master changes the bus four times, counts each change, and stays
/// on Bdefault.
#[test]
fn after_an_even_ntoggle_the_master_stays_on_bdefault() {
    let mut manager = started(Parameters { ctoggle: 9, ..PARAMETERS });
    for (count, from) in [NOMINAL, REDUNDANT, NOMINAL, REDUNDANT].into_iter().enumerate() {
        assert_eq!(usize::from(ctoggle(&manager)), count);
        let at = 1_000 * (count as u64 + 1);
        assert_eq!(decisions(&mut manager, at), [(at, unheard(from))]);
    }
    assert_eq!(decisions(&mut manager, 60_000), [(5_000, Action::GaveUp { bus: NOMINAL })]);
    assert_eq!(ctoggle(&manager), 4);
}

/// Given Ntoggle 255, Then the master does not give up, and Ctoggle stays at its greatest value.
#[test]
fn with_ntoggle_255_the_master_never_gives_up() {
    let mut manager = started(Parameters { ntoggle: 255, ..PARAMETERS });
    let changes = decisions(&mut manager, 300_000);
    assert_eq!(changes.len(), 300);
    assert_eq!(changes[299], (300_000, unheard(REDUNDANT)));
    assert_eq!(ctoggle(&manager), 255);
}

#[test]
fn after_an_odd_ntoggle_the_master_stays_on_the_other_bus() {
    let mut manager = started(Parameters { ntoggle: 1, ..PARAMETERS });
    let expected = [(1_000, unheard(NOMINAL)), (2_000, Action::GaveUp { bus: REDUNDANT })];
    assert_eq!(decisions(&mut manager, 30_000), expected);
    assert_eq!((manager.active(), ctoggle(&manager)), (REDUNDANT, 1));
}

/// Given Ttoggle or Ntoggle 0, Then neither silence nor a missing acknowledgement moves the master, but a command does.
///
/// Verifies: ECSS 5.3.3.2.3e, 5.3.3.2.3i
/// Notices: ECSS 5.3.3.2.3e: a command does not move a master that changes no bus itself.
/// Notices: ECSS 5.3.3.2.3i: a command does not move a master that changes no bus itself.
#[test]
fn with_ttoggle_or_ntoggle_zero_only_a_command_moves_the_master() {
    for parameters in [Parameters { ntoggle: 0, ..PARAMETERS }, Parameters { ttoggle: 0, ..PARAMETERS }] {
        let mut manager = started(parameters);
        assert_eq!(decisions(&mut manager, 20_000), []);
        hear(&mut manager, NOMINAL, 2, 20_000);
        manager.on_health(NOMINAL, ALONE, true, ms(20_010));
        assert_eq!(decisions(&mut manager, 30_000), [(20_100, Action::Lost(node(2)))]);
        manager.request(REDUNDANT);
        assert_eq!(manager.poll(ms(30_000)), Some(switched(NOMINAL, SwitchCause::Commanded)));
        assert_eq!(ctoggle(&manager), 0, "a command is no toggle");
    }
}

/// Given a master that gave up on the nominal bus, When its slave is heard on the redundant bus only, Then the master
/// goes there, and Ctoggle counts that change alone.
#[test]
fn a_slave_heard_after_giving_up_begins_a_new_search() {
    let mut manager = started(PARAMETERS);
    decisions(&mut manager, 6_000);
    let mut done = vec![];
    for at in (6_010..6_500).step_by(40) {
        hear(&mut manager, REDUNDANT, 2, at);
        done.extend(decisions(&mut manager, at + 39));
    }
    let moves: Vec<_> = done.iter().map(|(_, action)| *action).collect();
    assert_eq!(moves, [switched(NOMINAL, SwitchCause::SlavesSilent)], "{done:?}");
    assert_eq!((manager.active(), ctoggle(&manager)), (REDUNDANT, 1));
}

/// Given a slave that was heard and fell silent, When the master searches, Then the change because of the silence is the
/// first of Ntoggle changes.
#[test]
fn the_change_because_of_silence_is_the_first_of_ntoggle() {
    let mut manager = started(Parameters { ntoggle: 2, ..PARAMETERS });
    hear(&mut manager, NOMINAL, 2, 10);
    let expected = [
        (110, Action::Lost(node(2))),
        (110, switched(NOMINAL, SwitchCause::SlavesSilent)),
        (1_110, unheard(REDUNDANT)),
        (2_110, Action::GaveUp { bus: NOMINAL }),
    ];
    assert_eq!(decisions(&mut manager, 30_000), expected);
    assert_eq!(ctoggle(&manager), 2);
}

/// When a client writes 3 to Ctoggle during a search, Then one change of Ntoggle 4 is left.
#[test]
fn a_search_of_the_master_continues_with_a_written_ctoggle() {
    let mut manager = started(PARAMETERS);
    assert_eq!(decisions(&mut manager, 1_500), [(1_000, unheard(NOMINAL))]);
    manager.configure(Parameters { ctoggle: 3, ..PARAMETERS }, ms(1_500));
    let expected = [(2_000, unheard(REDUNDANT)), (3_000, Action::GaveUp { bus: NOMINAL })];
    assert_eq!(decisions(&mut manager, 30_000), expected);
}

/// When the bus is changed by command, Then the search begins anew, also after giving up.
#[test]
fn a_command_begins_a_new_search_of_the_master() {
    let mut manager = started(Parameters { ntoggle: 1, ..PARAMETERS });
    decisions(&mut manager, 10_000);
    manager.request(NOMINAL);
    let expected = [
        (10_000, switched(REDUNDANT, SwitchCause::Commanded)),
        (11_000, unheard(NOMINAL)),
        (12_000, Action::GaveUp { bus: REDUNDANT }),
    ];
    let mut done = vec![(10_000, manager.poll(ms(10_000)).unwrap())];
    done.extend(decisions(&mut manager, 30_000));
    assert_eq!(done, expected);
}

/// When a standby takes over, Then it begins with Ctoggle 0.
#[test]
fn a_master_that_takes_over_searches_anew() {
    let mut manager = started(Parameters { ntoggle: 1, ..PARAMETERS });
    decisions(&mut manager, 10_000);
    manager.stand_by();
    manager.take_over(NOMINAL, 0, ms(10_000));
    assert_eq!(ctoggle(&manager), 0);
    let expected = [(11_000, unheard(NOMINAL)), (12_000, Action::GaveUp { bus: REDUNDANT })];
    assert_eq!(decisions(&mut manager, 30_000), expected);
}

/// A frame of a node that does not count does not end a search.
///
/// Verifies: ECSS 5.3.3.2.3h
/// Notices: ECSS 5.3.3.2.3h: a master that gave up once never searches again.
#[test]
fn a_foreign_node_does_not_free_a_master_that_gave_up() {
    let mut manager = started(Parameters { ntoggle: 1, ..PARAMETERS });
    decisions(&mut manager, 10_000);
    let foreign_node: Option<NodeId> = Some(node(5));
    manager.on_frame(REDUNDANT, foreign_node, ms(10_000));
    assert_eq!(decisions(&mut manager, 30_000), []);
    manager.on_frame(NOMINAL, Some(node(2)), ms(30_000));
    assert_ne!(decisions(&mut manager, 60_000), [], "another search");
}
