//! Bus selection without a master: Ttoggle, Ntoggle, giving up, late messages.
//!
//! Verifies: ECSS 8.3.3h

use can_twin::wire::time::Time;
use ecss_can::node::SlaveEvent;
use ecss_can::profile::Profile;
use ecss_can::redundancy::BusCause;
use ecss_can::types::{Bus, NmtState};

use crate::support::*;

/// Returns a world with slaves that wait for a master, which is powered at `master`.
fn waiting(profile: Profile, slaves: u8, master: Time) -> MissionWorld {
    MissionWorld::of(profile, slaves, |world| world.powered_at(MASTER, master))
}

fn gave_up(event: &SlaveEvent) -> bool {
    matches!(event, SlaveEvent::GaveUp { .. })
}

fn toggled(event: &SlaveEvent) -> bool {
    matches!(event, SlaveEvent::ActiveBus { cause: BusCause::Toggled, .. })
}

/// Verifies: ECSS 8.3.3i, 8.3.3j, 8.3.3d
#[test]
fn after_even_number_of_switches_slave_stays_on_default_bus() {
    for bdefault in Bus::ALL {
        let profile = Profile { ntoggle: 4, bdefault, ..MIXED };
        let mut world = waiting(profile, 3, ms(60_000));
        world.run_until(ms(20_000));
        for node in [TWO, FOUR] {
            let times: Vec<u64> =
                told(&world, node, Time::ZERO, toggled).iter().map(|at| at.as_us() / 1_000).collect();
            assert_eq!(times, [500, 1_000, 1_500, 2_000]);
            assert_eq!(told_once(&world, node, Time::ZERO, gave_up).as_us() / 1_000, 2_500);
            assert_eq!(world.active(node), Some(bdefault));
            assert_eq!(world.state(node), Some(NmtState::PreOperational));
        }
        // They continue to send heartbeats there, and on no other bus.
        assert!(!since(&world, bdefault, 0x704, ms(19_000)).is_empty());
        assert!(world.frames(bdefault.other()).iter().all(|sent| sent.end < ms(2_100)));
    }
}

/// Verifies: ECSS 8.3.3j, 8.3.3f, 8.3.3g, 8.3.3k
#[test]
fn late_master_after_odd_switches_is_found_by_slaves_hearing_it() {
    let profile = Profile { ntoggle: 3, ..MIXED };
    let mut world = waiting(profile, 3, ms(5_000));
    world.run_until(ms(4_900));
    for node in [TWO, THREE, FOUR] {
        assert_eq!(world.active(node), Some(Bus::Redundant), "the bus reached");
        told_once(&world, node, Time::ZERO, gave_up);
    }
    world.run_until(ms(6_000));
    // Parallel slaves hear the nominal bus as well; the selective one waits on the redundant bus.
    for node in [TWO, THREE] {
        told_once(&world, node, ms(5_000), changed_bus(Bus::Nominal, BusCause::Found));
        assert_eq!(world.state(node), Some(NmtState::Operational));
    }
    assert_eq!(
        (world.active(FOUR), world.state(FOUR)),
        (Some(Bus::Redundant), Some(NmtState::PreOperational))
    );
    // A message there makes it active: that of a foreign node with an identifier of the master.
    world.inject(Bus::Redundant, standard(0x701, &[0x05]));
    world.run_for(ms(10));
    told_once(&world, FOUR, ms(6_000), changed_bus(Bus::Redundant, BusCause::Found));
}

/// Verifies: ECSS 8.3.3g, 8.3.3k, 6.5.1a.1
#[test]
fn start_command_on_other_bus_ends_the_search_and_is_obeyed() {
    let mut world = waiting(MIXED, 3, ms(60_000));
    world.run_until(ms(300));
    world.inject(Bus::Redundant, standard(0x000, &[0x01, 0x02]));
    world.run_for(ms(10));
    told_once(&world, TWO, ms(300), changed_bus(Bus::Redundant, BusCause::Found));
    assert_eq!(world.state(TWO), Some(NmtState::Operational));
    // The command was for slave 2. Slave 3 received it too, and slave 4 is on the other bus.
    assert_eq!(
        (world.active(THREE), world.state(THREE)),
        (Some(Bus::Redundant), Some(NmtState::PreOperational))
    );
    assert_eq!(world.active(FOUR), Some(Bus::Nominal));
}

/// Given a malformed NMT message on the other bus, then the search continues.
#[test]
fn a_malformed_message_on_the_other_bus_does_not_end_the_search() {
    let mut world = waiting(MIXED, 3, ms(60_000));
    world.run_until(ms(300));
    world.inject(Bus::Redundant, standard(0x000, &[0x01]));
    world.inject(Bus::Redundant, standard(0x701, &[0x42]));
    world.run_for(ms(100));
    assert!(world.slaves().iter().all(|node| world.active(*node) == Some(Bus::Nominal)));
    world.run_until(ms(550));
    assert!(world.slaves().iter().all(|node| world.active(*node) == Some(Bus::Redundant)));
}

/// Verifies: ECSS 8.3.3e.1, 8.3.3f, 8.3.3i, 6.5.2b
#[test]
fn without_toggling_missed_master_means_waiting_pre_operational() {
    for profile in [Profile { ntoggle: 0, ..MIXED }, Profile { ttoggle: 0, ..MIXED }] {
        let mut world = running(profile, 3);
        let off = world.now();
        world.power_off(MASTER);
        world.run_for(ms(9_000));
        for node in [TWO, THREE, FOUR] {
            told_once(&world, node, off, entered(NmtState::PreOperational));
            assert!(told(&world, node, Time::ZERO, toggled).is_empty());
            assert_eq!(world.active(node), Some(Bus::Nominal));
        }
        assert_eq!(world.frames(Bus::Redundant), []);
        world.power_on(MASTER);
        world.run_for(ms(1_000));
        assert!(world.all_operational());
    }
}

/// Verifies: ECSS 8.3.3e, 8.3.2b, 8.3.3e.2
#[test]
fn a_lost_master_is_searched_on_both_buses_in_turn() {
    let mut world = running(MIXED, 3);
    world.run_for(ms(37));
    world.power_off(MASTER);
    let off = world.now();
    world.run_for(ms(2_200));
    let last = between(&world, Bus::Nominal, 0x701, Time::ZERO, off).pop().expect("a heartbeat").end;
    for node in [TWO, FOUR] {
        let times = told(&world, node, off, toggled);
        assert_eq!(times.len(), 4);
        for (toggle, at) in (1_u64..).zip(times) {
            let expected = ms(500 * toggle);
            assert!(at.since(last).0.abs_diff(expected.0) < expected.0 / 20);
        }
    }
}

/// Given a heartbeat that returns after the first miss and before the switch, then the slave stays on the bus and is
/// started.
///
/// Verifies: ECSS 8.3.3e.1, 8.3.3f, 8.3.3c
#[test]
fn master_that_returns_before_switch_starts_its_slaves_again() {
    let mut world = running(MIXED, 3);
    let off = world.now();
    world.power_off(MASTER);
    world.run_for(ms(350));
    assert!(world.slaves().iter().all(|node| world.state(*node) == Some(NmtState::PreOperational)));
    world.power_on(MASTER);
    world.run_for(ms(300));
    assert!(world.all_operational());
    assert!(world.slaves().iter().all(|node| told(&world, *node, off, toggled).is_empty()));
}
