//! The boot-up process with real slaves: checked, configured, started.

use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use ecss_can::boot::{AssignedSlave, BootError, BootPolicy, BootProgress, Difference, Expected, Setting};
use ecss_can::nmt::{Command, Target};
use ecss_can::node::{MasterEvent, MasterRequest};
use ecss_can::profile::Profile;
use ecss_can::types::{Address, Bus, Duration, NmtState, NodeId};
use ecss_can_worlds::world::World;
use mission::{LIBRECUBE, STANDARD};

use crate::support::*;

const ERROR_BEHAVIOUR: Address = Address::new(0x1029, 1);
const STORE: Address = Address::new(0x6300, 0);

const fn mandatory(node: NodeId) -> AssignedSlave {
    let expected = Expected { device_type: 0, identity: [0, 0x5015, 1 << 16, 0], stamp: [100, 200] };
    AssignedSlave { node, mandatory: true, expected }
}

const fn setting(node: NodeId, at: Address, value: &'static [u8]) -> Setting {
    Setting { node, at, value }
}

/// Slaves 2, 3 and 4 mandatory, two settings each, of which one is as at power-on.
const THREE_MANDATORY: Profile = Profile {
    slaves: &[mandatory(TWO), mandatory(THREE), mandatory(FOUR)],
    settings: &[
        setting(TWO, Address::new(0x1016, 1), &[250, 0, 1, 0]),
        setting(TWO, ERROR_BEHAVIOUR, &[1]),
        setting(THREE, ERROR_BEHAVIOUR, &[1]),
        setting(FOUR, ERROR_BEHAVIOUR, &[2]),
        setting(FOUR, STORE, b"more text than one frame holds"),
    ],
    boot: BootPolicy { time: Duration::from_millis(500), goes_on: false },
    ..STANDARD
};

/// Returns the progress of a slave that was reported after `from`.
fn progress(world: &World, slave: NodeId, from: Time) -> Vec<BootProgress> {
    let events = master_told(world, from).into_iter();
    events
        .filter_map(|event| match event {
            MasterEvent::Boot { node, progress } if node == slave => Some(progress),
            _ => None,
        })
        .collect()
}

fn failures(world: &World, from: Time) -> Vec<(NodeId, BootError, u32)> {
    let events = master_told(world, from).into_iter();
    events
        .filter_map(|event| match event {
            MasterEvent::BootFailed { node, failure } => {
                Some((node, failure.error, failure.cause.abort_code()))
            }
            _ => None,
        })
        .collect()
}

fn completed(world: &World, from: Time) -> usize {
    master_told(world, from).iter().filter(|event| **event == MasterEvent::BootCompleted).count()
}

fn error_behaviour(world: &MissionWorld, node: NodeId) -> u8 {
    world.slave(node, |slave| slave.objects().communication.nmt.error_behaviour[0])
}

fn stamp(world: &MissionWorld, node: NodeId) -> [u32; 2] {
    world.slave(node, |slave| slave.objects().communication.configuration)
}

/// Returns the SDO requests to a slave after `from`.
fn requests(world: &World, bus: Bus, node: NodeId, from: Time) -> Vec<[u8; 8]> {
    let frames = since(world, bus, 0x600 + u16::from(node.get()), from);
    frames.iter().map(|sent| sent.frame.data).collect()
}

/// Verifies: ECSS 6.1a, 6.5.1a.1
#[test]
fn mandatory_slaves_are_checked_configured_started_before_sync() {
    let mut world = MissionWorld::new(THREE_MANDATORY, 3);
    world.run_until(ms(1_000));
    use BootProgress::{Awaited, Booted, Checking, Comparing, Configuring, Queued, Started};
    assert_eq!(
        progress(&world, TWO, Time::ZERO),
        [Awaited, Queued, Checking, Comparing, Configuring, Started, Booted]
    );
    assert!(world.all_operational());
    let first_sync = since(&world, Bus::Nominal, 0x080, Time::ZERO)[0].start;
    for (node, behaviour) in [(TWO, 1), (THREE, 1), (FOUR, 2)] {
        assert_eq!(error_behaviour(&world, node), behaviour);
        assert_eq!(stamp(&world, node), [100, 200]);
        let started = told_once(&world, node, Time::ZERO, entered(NmtState::Operational));
        assert!(started < first_sync);
    }
    let text = world.slave(FOUR, |slave| slave.objects().application.store.as_bytes().to_vec());
    assert!(text.starts_with(b"more text than one frame holds"));
    assert_eq!((completed(&world, Time::ZERO), failures(&world, Time::ZERO)), (1, vec![]));
}

/// Given a slave that a foreign node stops while the master checks it, then it is checked again and started. A stopped
/// slave answers no SDO.
///
/// Verifies: ECSS 8.3.3f, 6.5.1a.1
#[test]
fn a_slave_that_is_stopped_while_it_is_checked_is_checked_again() {
    const ONE: Profile = Profile {
        slaves: &[AssignedSlave { mandatory: false, ..mandatory(THREE) }],
        settings: &[setting(THREE, ERROR_BEHAVIOUR, &[1])],
        ..STANDARD
    };
    let mut world = MissionWorld::new(ONE, 2);
    let mut steps = 0;
    while progress(&world, THREE, Time::ZERO).last() != Some(&BootProgress::Checking) {
        world.run_for(Time::from_us(50));
        steps += 1;
        assert!(steps < 20_000, "it is never checked");
    }
    world.inject(Bus::Nominal, WireFrame::standard(0x000, &[0x02, 3]));
    world.run_for(ms(5_000));
    assert!(world.all_operational(), "{:?}", progress(&world, THREE, Time::ZERO));
    assert_eq!(error_behaviour(&world, THREE), 1);
}

#[test]
fn with_all_slaves_there_the_boot_process_does_not_delay_sync() {
    let mut worlds = [LIBRECUBE, Profile { slaves: &[], settings: &[], ..LIBRECUBE }].map(|profile| {
        let mut world = MissionWorld::new(profile, 3);
        world.run_until(ms(6_000));
        world
    });
    let [with, without] =
        worlds.each_mut().map(|world| since(world, Bus::Nominal, 0x080, Time::ZERO)[0].start);
    assert!(with.since(without) < ms(1) || without.since(with) < ms(1));
    let [world, _] = &worlds;
    assert_eq!(stamp(world, TWO), [12_321, 43_200_000]);
    let operational = told_once(world, FOUR, Time::ZERO, entered(NmtState::Operational));
    assert!(operational < ms(30), "the last one starts after {} us", operational.as_us());
    assert_eq!(completed(world, Time::ZERO), 0, "no slave is mandatory");
}

/// Verifies: ECSS 6.9d
#[test]
fn slave_of_other_product_code_is_not_started_and_sync_waits() {
    let mut other = mandatory(THREE);
    other.expected.identity[1] = 0x5016;
    let slaves: &'static [AssignedSlave] = Box::leak(Box::new([mandatory(TWO), other]));
    let mut world = MissionWorld::new(Profile { slaves, ..THREE_MANDATORY }, 2);
    world.run_until(ms(3_000));
    assert_eq!(world.state(TWO), Some(NmtState::Operational));
    assert_eq!(world.state(THREE), Some(NmtState::PreOperational));
    assert_eq!(failures(&world, Time::ZERO), [(THREE, BootError::Product, 0)]);
    assert_eq!(progress(&world, THREE, Time::ZERO).last(), Some(&BootProgress::Failed));
    assert!(since(&world, Bus::Nominal, 0x080, Time::ZERO).is_empty());
    let shown = world.master(|master| {
        let objects = &master.objects().application.network;
        (objects.boot_progress[2], objects.boot_error[2], objects.boot_progress[1])
    });
    assert_eq!(shown, (8, b'M', 6));

    // Given the right one is expected and the slave boots up again
    world.write(MASTER, Address::new(0x1F86, 3), &0x5015_u32.to_le_bytes());
    world.reset(THREE);
    world.run_for(ms(500));
    assert!(world.all_operational());
    assert!(!since(&world, Bus::Nominal, 0x080, Time::ZERO).is_empty());
    assert_eq!(completed(&world, Time::ZERO), 1);
}

/// Verifies: ECSS 6.9d
#[test]
fn missing_mandatory_slave_reported_after_boot_time_and_awaited() {
    let mut world = MissionWorld::of(THREE_MANDATORY, 3, |world| world.powered_at(FOUR, ms(2_000)));
    world.run_until(ms(1_900));
    assert_eq!(failures(&world, Time::ZERO), [(FOUR, BootError::Silent, 0)]);
    assert!(since(&world, Bus::Nominal, 0x080, Time::ZERO).is_empty());
    assert_eq!(world.state(TWO), Some(NmtState::Operational));
    world.run_until(ms(2_500));
    assert!(world.all_operational());
    assert!(!since(&world, Bus::Nominal, 0x080, Time::ZERO).is_empty());
}

/// Verifies: ECSS 6.9d
#[test]
fn by_policy_network_goes_on_and_takes_up_missing_slave_later() {
    let boot = BootPolicy { goes_on: true, ..THREE_MANDATORY.boot };
    let mut world =
        MissionWorld::of(Profile { boot, ..THREE_MANDATORY }, 3, |world| world.powered_at(FOUR, ms(2_000)));
    world.run_until(ms(1_900));
    assert_eq!(failures(&world, Time::ZERO), [(FOUR, BootError::Silent, 0)]);
    let first_sync = since(&world, Bus::Nominal, 0x080, Time::ZERO)[0].start;
    assert!(first_sync >= ms(500) && first_sync < ms(601));
    assert_eq!(completed(&world, Time::ZERO), 1);
    world.run_until(ms(2_500));
    assert!(world.all_operational());
    assert_eq!(progress(&world, FOUR, Time::ZERO).last(), Some(&BootProgress::Booted));
}

#[test]
fn a_slave_that_lost_its_power_is_configured_again() {
    let mut world = running(THREE_MANDATORY, 3);
    let from = world.now();
    world.reset(TWO);
    world.run_for(ms(500));
    assert!(world.all_operational());
    assert_eq!((error_behaviour(&world, TWO), stamp(&world, TWO)), (1, [100, 200]));
    assert_eq!(progress(&world, TWO, from).last(), Some(&BootProgress::Booted));
    // No other slave was disturbed.
    assert!(requests(&world, Bus::Nominal, THREE, from).is_empty());
    assert!(progress(&world, THREE, from).is_empty());
}

/// Verifies: ECSS 6.1a, 6.10l, 6.10m
#[test]
fn what_a_slave_has_by_its_stamp_is_not_written_again() {
    let mut world = running(THREE_MANDATORY, 3);
    let from = world.now();
    world.request(MasterRequest::Boot(TWO));
    world.run_for(ms(200));
    let read = |index: u16, sub: u8| [0x40, index as u8, (index >> 8) as u8, sub, 0, 0, 0, 0];
    let identity = [read(0x1000, 0), read(0x1018, 2), read(0x1018, 3)];
    let stamps = [read(0x1020, 1), read(0x1020, 2)];
    // COB-IDs of its emergencies and TPDOs, which no other node may send.
    let sent = [read(0x1014, 0)].into_iter().chain((0x1800..0x1808).map(|index| read(index, 1)));
    let expected: Vec<_> = identity.into_iter().chain(stamps).chain(sent).collect();
    assert_eq!(requests(&world, Bus::Nominal, TWO, from), expected);
    // Given another client that changes a setting: the stamp is cleared, and the setting is written.
    let from = world.now();
    world.write(TWO, Address::new(0x1029, 1), &[0]);
    world.request(MasterRequest::Boot(TWO));
    world.run_for(ms(200));
    assert_eq!((error_behaviour(&world, TWO), stamp(&world, TWO)), (1, [100, 200]));
    let written: Vec<u16> = requests(&world, Bus::Nominal, TWO, from)
        .iter()
        .filter(|data| data[0] & 0xE0 == 0x20)
        .map(|data| u16::from_le_bytes([data[1], data[2]]))
        .collect();
    assert_eq!(written, [0x1029, 0x1020, 0x1020]);
}

/// Verifies: ECSS 8.3.3b
#[test]
fn fail_over_keeps_configuration_and_asks_parallel_slaves_for_errors_alone() {
    let mut world = running(THREE_MANDATORY, 3);
    let cut = world.now();
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_for(ms(1_000));
    assert!(world.all_operational());
    assert_eq!(world.master_bus(), Bus::Redundant);
    for (node, behaviour) in [(TWO, 1), (THREE, 1), (FOUR, 2)] {
        assert_eq!(error_behaviour(&world, node), behaviour);
        assert_eq!(requests(&world, Bus::Redundant, node, cut), [[0x40, 0x01, 0x10, 0, 0, 0, 0, 0]]);
    }
}

/// Verifies: ECSS 8.3.3f, 8.3.3h
#[test]
fn toggled_selective_slave_is_started_at_once_and_then_checked() {
    let mut world = running(Profile { selective: &[FOUR], ..THREE_MANDATORY }, 3);
    let cut = world.now();
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_for(ms(1_500));
    assert!(world.all_operational());
    let word = since(&world, Bus::Redundant, 0x704, cut).remove(0);
    let started = told_once(&world, FOUR, cut, entered(NmtState::Operational));
    assert!(started.since(word.end) < ms(2));
    assert!(!requests(&world, Bus::Redundant, FOUR, cut).is_empty());
    assert_eq!(progress(&world, FOUR, cut).last(), Some(&BootProgress::Booted));
}

/// Given a slave that is reset on the nominal bus at the moment when that is cut, so that its boot-up message is lost
/// When it follows the master to the redundant bus
/// Then it is started at once, found without its configuration, configured and started again.
///
/// Verifies: ECSS 8.3.3f
#[test]
fn a_slave_reset_unheard_on_the_bus_left_is_configured() {
    for selective in [&[][..], &[TWO]] {
        let mut world = running(Profile { selective, ..THREE_MANDATORY }, 3);
        let cut = world.now();
        cut_next_to_master(&mut world, Bus::Nominal);
        world.reset(TWO);
        world.run_for(ms(2_000));
        assert!(world.all_operational());
        assert_eq!((error_behaviour(&world, TWO), stamp(&world, TWO)), (1, [100, 200]), "{selective:?}");
        let lost: Vec<_> = master_told(&world, cut)
            .into_iter()
            .filter_map(|event| match event {
                MasterEvent::ConfigurationLost { node, difference } => Some((node, difference)),
                _ => None,
            })
            .collect();
        let difference = Difference { at: Address::new(0x1020, 1), expected: 100, found: 0 };
        assert_eq!(lost, [(TWO, difference)], "{selective:?}");
        let entries = told(&world, TWO, cut, entered(NmtState::Operational));
        assert_eq!(entries.len(), 2, "at once, and when it was configured: {entries:?}");
        let word = since(&world, Bus::Redundant, 0x702, cut).remove(0);
        assert!(entries[0].since(word.end) < ms(2), "{selective:?}");
    }
}

/// Verifies: ECSS 8.3.3b, 8.3.3f
#[test]
fn bus_cut_during_boot_restarts_the_process_on_the_other_bus() {
    let mut world = MissionWorld::of(THREE_MANDATORY, 3, |world| world.powered_at(TWO, ms(1_000)));
    world.run_until(ms(999));
    assert_eq!(world.state(THREE), Some(NmtState::Operational));
    // The boot-up message of slave 2 has ended, its device type is being read.
    world.run_until(Time::from_us(1_000_300));
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_until(ms(3_000));
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
    assert_eq!((error_behaviour(&world, TWO), stamp(&world, TWO)), (1, [100, 200]));
    assert_eq!(failures(&world, ms(999)), []);
}

#[test]
fn slave_losing_power_in_boot_is_reported_and_booted_on_return() {
    let mut world = MissionWorld::of(THREE_MANDATORY, 3, |world| world.powered_at(TWO, ms(1_000)));
    world.run_until(Time::from_us(1_000_400));
    let from = world.now();
    world.power_off(TWO);
    world.run_for(ms(1_900));
    let told = failures(&world, from);
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0].0, TWO);
    assert!(
        matches!(told[0].1, BootError::Lost | BootError::NoResponse | BootError::Configuration),
        "{told:?}"
    );
    world.power_on(TWO);
    world.run_for(ms(500));
    assert!(world.all_operational());
    assert_eq!(stamp(&world, TWO), [100, 200]);
}

/// Verifies: ECSS 6.5.1a.1
#[test]
fn slave_held_by_application_is_configured_but_not_started() {
    let mut world = running(THREE_MANDATORY, 3);
    world.nmt(Command::EnterPreOperational, Target::Node(TWO));
    world.run_for(ms(50));
    world.reset(TWO);
    world.run_for(ms(500));
    assert_eq!(world.state(TWO), Some(NmtState::PreOperational));
    assert_eq!(error_behaviour(&world, TWO), 1);
    world.nmt(Command::Start, Target::Node(TWO));
    world.run_for(ms(50));
    assert!(world.all_operational());
}
