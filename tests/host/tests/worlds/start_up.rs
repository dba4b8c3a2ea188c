//! Power-on, boot-up, heartbeats and module control.

use can_twin::wire::time::Time;
use ecss_can::nmt::{Command, Target};
use ecss_can::profile::Profile;
use ecss_can::redundancy::BusCause;
use ecss_can::types::{Bus, NmtState, NodeId};
use mission::{LIBRECUBE, STANDARD};

use crate::support::*;

/// Verifies: ECSS 6.5.3a, 6.5.4a, 8.3.2a
#[test]
fn every_slave_boots_on_the_default_bus_and_is_started() {
    for profile in [STANDARD, LIBRECUBE] {
        let mut world = MissionWorld::new(profile, 3);
        world.run_until(ms(1_000));
        for node in [TWO, THREE, FOUR] {
            let heartbeats = since(&world, Bus::Nominal, 0x700 + u16::from(node.get()), Time::ZERO);
            let states: Vec<u8> = heartbeats.iter().map(|sent| sent.frame.data[0]).collect();
            assert_eq!(states[0], 0x00, "boot-up is the first word");
            assert!(states[1..].iter().all(|state| [0x7F, 0x05].contains(state)), "{states:X?}");
            assert!(
                states[1..].is_sorted_by(|a, b| a >= b),
                "pre-operational before operational: {states:X?}"
            );
            assert_eq!(states.last(), Some(&0x05));
            assert_eq!(world.state(node), Some(NmtState::Operational));
            assert_eq!(world.active(node), Some(Bus::Nominal));
        }
        assert_eq!(world.frames(Bus::Redundant), []);
    }
}

/// Verifies: ECSS 8.3.2a
#[test]
fn a_default_of_redundant_is_where_everybody_starts() {
    let mut world = MissionWorld::new(Profile { bdefault: Bus::Redundant, ..STANDARD }, 2);
    world.run_until(ms(1_000));
    assert!(world.all_operational());
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert_eq!(world.frames(Bus::Nominal), []);
}

/// Verifies: ECSS 6.5.2a, 8.3.3a, 8.3.3d
#[test]
fn heartbeats_of_everybody_come_every_period_on_the_active_bus() {
    let mut world = running(STANDARD, 3);
    world.run_until(ms(3_000));
    for id in 0x701..=0x704 {
        let frames = between(&world, Bus::Nominal, id, ms(1_000), ms(3_000));
        assert_eq!(frames.len(), 20, "{id:03X}");
        // Other frames delay the end by less than a millisecond.
        assert!(
            periods_us(&frames).iter().all(|us| us.abs_diff(100_000) < 1_000),
            "{:?}",
            periods_us(&frames)
        );
    }
    assert_eq!(world.frames(Bus::Redundant), []);
}

/// Given running slaves, when a foreign node stops all of them, then the master starts them again.
///
/// Verifies: ECSS 6.5.1a.1, 6.5.1a.2
#[test]
fn slaves_stopped_by_somebody_else_are_started_again() {
    let mut world = running(STANDARD, 2);
    let from = world.now();
    world.inject(Bus::Nominal, standard(0x000, &[0x02, 0x00]));
    world.run_for(ms(200));
    told_once(&world, TWO, from, entered(NmtState::Stopped));
    assert!(world.all_operational());
}

/// Verifies: ECSS 6.5.1a, 6.5.1a.1, 6.5.1a.2, 6.5.1a.3, 6.5.4a
#[test]
fn module_control_commands_are_obeyed_by_whom_they_address() {
    let mut world = running(STANDARD, 2);
    world.nmt(Command::Stop, Target::Node(TWO));
    world.run_for(ms(500));
    assert_eq!(world.state(TWO), Some(NmtState::Stopped));
    assert_eq!(world.state(THREE), Some(NmtState::Operational));

    world.nmt(Command::EnterPreOperational, Target::All);
    world.run_for(ms(500));
    assert_eq!(world.state(TWO), Some(NmtState::PreOperational));
    assert_eq!(world.state(THREE), Some(NmtState::PreOperational));

    world.nmt(Command::Start, Target::All);
    world.run_for(ms(50));
    assert!(world.all_operational());
}

/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5, 6.5.3a
#[test]
fn reset_commands_lead_through_boot_up_back_to_operational() {
    for command in [Command::ResetNode, Command::ResetCommunication] {
        let mut world = running(STANDARD, 2);
        let from = world.now();
        world.nmt(command, Target::Node(TWO));
        world.run_for(ms(1_000));
        let words: Vec<u8> =
            since(&world, Bus::Nominal, 0x702, from).iter().map(|sent| sent.frame.data[0]).collect();
        assert_eq!(words.iter().filter(|state| **state == 0).count(), 1, "{command:?}: {words:X?}");
        assert!(world.all_operational(), "{command:?}");
        let uptime = world.clock(TWO).map(|clock| clock.instant(world.now()).as_micros());
        let rebooted = uptime.is_some_and(|us| us < 1_010_000);
        assert_eq!(rebooted, command == Command::ResetNode, "only Reset Node restarts the clock");
        assert_eq!(
            told(&world, THREE, from, |_| true).len(),
            told(&world, THREE, from, heartbeat_like).len()
        );
    }
}

/// Given a master and slaves that get power together, when their boot-up messages begin with the same bit, then that of the master, which
/// has the lowest Node-ID, is on the bus first, and those of slaves follow by Node-ID.
///
/// Verifies: ECSS 9.1a
/// Notices: ECSS 9.1a: heartbeat COB-IDs count down from 780h.
#[test]
fn boot_up_message_of_the_master_wins_arbitration() {
    let mut world = MissionWorld::new(STANDARD, 3);
    world.run_until(ms(50));
    let boots = world.frames(Bus::Nominal).iter().filter(|sent| sent.frame.payload() == [0]);
    let order: Vec<_> = boots.map(|sent| (sent.id(), sent.node)).collect();
    let expected = [(0x701, MASTER), (0x702, TWO), (0x703, THREE), (0x704, FOUR)];
    assert_eq!(order, expected.map(|(id, node)| (Some(id), Some(node))));
}

/// Given running slaves, when the master resets all of them (node 0), then each boots up once and is started again.
/// Reset node restarts the clock of each, Reset communication of none. The master continues.
///
/// Verifies: ECSS 6.5.1a.4, 6.5.1a.5, 6.5.3a
/// Notices: ECSS 6.5.1a.4: a slave ignores Reset node for all nodes.
/// Notices: ECSS 6.5.1a.5: a slave ignores Reset communication for all nodes.
#[test]
fn reset_commands_to_all_nodes_reset_every_slave() {
    for command in [Command::ResetNode, Command::ResetCommunication] {
        let mut world = running(MIXED, 3);
        let from = world.now();
        world.nmt(command, Target::All);
        world.run_for(ms(1_000));
        for node in [TWO, THREE, FOUR] {
            let heartbeats = since(&world, Bus::Nominal, 0x700 + u16::from(node.get()), from);
            let boots = heartbeats.iter().filter(|sent| sent.frame.payload() == [0]).count();
            assert_eq!(boots, 1, "{command:?}, {node:?}");
            let uptime = world.clock(node).map(|clock| clock.instant(world.now()).as_micros());
            let is_restarted = uptime.is_some_and(|us| us < 1_010_000);
            assert_eq!(is_restarted, command == Command::ResetNode, "{node:?}");
        }
        assert!(world.all_operational(), "{command:?}");
        let periods = periods_us(&since(&world, Bus::Nominal, 0x701, from));
        assert!(periods.len() >= 8 && periods.iter().all(|us| us.abs_diff(100_000) < 2_000), "{periods:?}");
    }
}

fn heartbeat_like(event: &ecss_can::node::SlaveEvent) -> bool {
    use ecss_can::node::SlaveEvent::{Heartbeat, Step, Sync, Time};
    matches!(event, Heartbeat { .. } | Step(_) | Sync { .. } | Time(_))
}

/// Verifies: ECSS 8.3.2b, 8.3.3g, 8.3.3f, 8.3.3h
#[test]
fn a_slave_started_before_the_master_toggles_and_is_found() {
    // 2 x 250 ms on each bus: at 3.2 s every slave listens on the nominal bus.
    let mut world = MissionWorld::of(MIXED, 3, |world| world.powered_at(MASTER, ms(3_200)));
    world.run_until(ms(3_000));
    for node in [TWO, THREE, FOUR] {
        assert_eq!(world.state(node), Some(NmtState::PreOperational));
        assert_eq!(told(&world, node, Time::ZERO, changed_bus(Bus::Redundant, BusCause::Toggled)).len(), 3);
    }
    world.run_until(ms(5_000));
    assert!(world.all_operational());
    assert_eq!(switches(&world, Time::ZERO), 0);
}

#[test]
fn a_master_started_before_its_slaves_does_not_switch_buses() {
    let late = |builder: ecss_can_worlds::Builder, node: NodeId| builder.powered_at(node, ms(5_000));
    let mut world = MissionWorld::of(MIXED, 3, |world| [TWO, THREE, FOUR].into_iter().fold(world, late));
    world.run_until(ms(6_500));
    assert!(world.all_operational());
    assert_eq!((world.master_bus(), switches(&world, Time::ZERO)), (Bus::Nominal, 0));
    assert_eq!(world.frames(Bus::Redundant), []);
}

/// Given a nominal bus that is cut next to the master before the master has heard a slave, then the master does not regard itself
/// as isolated. In profile librecube it first hears its assigned slaves on the redundant bus, after their toggling time of 12.5 s.
/// It gives them a toggling time and two heartbeat periods (13 s) to come to its bus. In profile standard no slave is assigned: it
/// changes the bus after a dwell of 10 s. Slaves with parallel access are found at once, those with selective access within a
/// further toggling time.
///
/// Verifies: ECSS 8.3.3b
#[test]
fn bus_cut_before_a_slave_was_heard_costs_a_dwell() {
    for (profile, dwell, toggling) in [(LIBRECUBE, ms(25_500), ms(12_500)), (MIXED, ms(10_000), ms(500))] {
        // The slaves boot after the master and after the cut.
        let late = |builder: ecss_can_worlds::Builder, node: NodeId| builder.powered_at(node, ms(100));
        let mut world =
            MissionWorld::of(profile, 3, |world| [TWO, THREE, FOUR].into_iter().fold(world, late));
        world.run_until(ms(50));
        cut_next_to_master(&mut world, Bus::Nominal);
        world.run_until(dwell - ms(100));
        assert_eq!(switches(&world, Time::ZERO), 0, "{}", profile.name);
        world.run_until(dwell + ms(300));
        assert_eq!(
            (switches(&world, Time::ZERO), world.master_bus()),
            (1, Bus::Redundant),
            "{}",
            profile.name
        );
        for node in [TWO, THREE] {
            assert_eq!(world.state(node), Some(NmtState::Operational), "{}", profile.name);
        }
        world.run_until(dwell + toggling + ms(300));
        assert!(world.all_operational(), "{}", profile.name);
    }
}

#[test]
fn fourteen_slaves_run_with_traffic_and_lose_nothing() {
    let mut world = MissionWorld::busy(STANDARD, 14, |world| world.seed(14));
    world.run_until(ms(5_000));
    assert!(world.all_operational());
    for node in world.slaves() {
        let commands =
            between(&world, Bus::Nominal, 0x300 + u16::from(node.get()), ms(1_000), ms(4_900)).len();
        assert!((38..=40).contains(&commands), "one per 100 ms, not {commands}");
        let diagnostics = world.diagnostics(node).expect("it has power");
        assert_eq!((diagnostics.overruns().get(), diagnostics.app_overflows().get()), (0, 0));
    }
    let diagnostics = world.diagnostics(MASTER).expect("it has power");
    assert_eq!((diagnostics.overruns().get(), diagnostics.app_overflows().get()), (0, 0));
}
