//! Noise on the bits, shorts, loose stubs and defective nodes, which the data link and the second bus handle.

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::link::port::{CanPort, ErrorState, Health, LastError};
use ecss_can::node::{MasterEvent, MasterRequest, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState, NodeId};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::world::World;
use mission::Command;
use mission::STANDARD;

use crate::support::*;

/// Makes a world with continuous commands and telemetry.
fn busy(profile: Profile, slaves: u8) -> MissionWorld {
    let mut world = MissionWorld::busy(profile, slaves, |world| world);
    world.run_until(ms(1_000));
    assert!(world.all_operational());
    world
}

/// Returns the reasons for which the master left a bus, and asserts that it did so in time.
fn causes(world: &World, from: Time) -> Vec<SwitchCause> {
    let log = world.log_of(MASTER).into_iter().filter(|(at, _)| *at >= from);
    let switched = log.filter_map(|(at, what)| match what {
        NodeEvent::Master(MasterEvent::BusSwitched { cause, .. }) => Some((at.since(from), cause)),
        _ => None,
    });
    let in_time = |(after, cause): (Time, SwitchCause)| {
        assert!(after <= ms(355), "the consumer time and a period, not {} us ({cause:?})", after.as_us());
        cause
    };
    switched.map(in_time).collect()
}

/// Returns the turns of the master whose commands a slave executed, in the order of execution.
fn executed(world: &MissionWorld, node: NodeId) -> Vec<u32> {
    turns(world, node).into_iter().map(|(_, turn)| turn).collect()
}

/// Verifies: ECSS 5.6.2a
#[test]
fn bit_errors_cost_repetitions_and_nothing_else() {
    for (rate, span) in [(1e-5, ms(20_000)), (1e-4, ms(5_000))] {
        let mut world = busy(STANDARD, 3);
        let from = world.now();
        Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::BitErrors { rate, seed: 7 }));
        world.run_for(span);
        assert!(world.counters(Bus::Nominal).destroyed > 0, "the noise at {rate:e} struck frames");
        Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::BitErrors { rate: 0.0, seed: 0 }));
        world.run_for(ms(100));
        assert_eq!(causes(&world, from), [], "{rate:e}");
        assert!(world.all_operational());
        assert_eq!(world.misread_frames(Bus::Nominal), 0);
        for node in world.slaves() {
            assert!(told(&world, node, from, entered(NmtState::PreOperational)).is_empty());
            // Every command was executed once and in order, though one whose end was disturbed for some arrived twice (ISO
            // 11898-1, 10.9: an error in the last bit of EOF).
            let values = executed(&world, node);
            let last = *values.last().expect("commands all the time");
            assert_eq!(values, (values[0]..=last).collect::<Vec<_>>());
            let meanwhile = executed_since(&world, node, from);
            assert!(meanwhile as u64 >= span.as_us() / 100_000, "{meanwhile} commands");
        }
    }
}

/// Verifies: ECSS 5.3.3.2.3e, 5.3.3.2.3i, 8.3.3b, 8.3.3b.1, 8.3.3e.2
/// Notices: ECSS 5.3.3.2.3e: a slave with selective access searches on one bus alone.
#[test]
fn a_bus_shorted_recessive_is_left_for_the_other_one() {
    let mut world = running(MIXED, 3);
    let from = world.now();
    world.strike(Bus::Nominal, Fault::Short { position_m: 4.0, level: true });
    world.run_for(ms(1_500));
    assert_eq!(causes(&world, from), [SwitchCause::SlavesSilent]);
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
    // No stale frame is sent after the fault.
    let over = world.now();
    world.strike(Bus::Nominal, Fault::ClearShorts);
    world.run_for(ms(1_000));
    assert!(since(&world, Bus::Nominal, 0x701, over).is_empty());
    assert!(world.all_operational());
}

/// Verifies: ECSS 5.3.3.2.3e, 5.3.3.2.3i, 8.3.3b, 8.3.3e.2
/// Notices: ECSS 5.3.3.2.3i: a slave with selective access searches on one bus alone.
#[test]
fn a_bus_shorted_dominant_is_left_for_the_other_one() {
    let mut world = running(MIXED, 3);
    let from = world.now();
    world.strike(Bus::Nominal, Fault::Short { position_m: 4.0, level: false });
    world.run_for(ms(2_000));
    assert_eq!(causes(&world, from), [SwitchCause::SlavesSilent]);
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
}

/// Verifies: ECSS 5.3.3.2.3d, 5.3.3.2.3g, 5.3.3.2.3h, 5.3.3.2.3j, 8.3.3f
#[test]
fn a_short_that_goes_away_leaves_no_ill_effects() {
    for level in [true, false] {
        for span in [ms(3), ms(60), ms(400), ms(3_000)] {
            let mut world = running(MIXED, 3);
            Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::Short { position_m: 4.0, level }));
            world.run_for(span);
            Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::ClearShorts));
            world.run_for(ms(6_000));
            assert!(world.all_operational(), "level {level} for {} us", span.as_us());
            let settled = world.now();
            world.run_for(ms(2_000));
            assert_eq!(switches(&world, settled), 0);
            let bus = world.master_bus();
            for id in 0x701..=0x704 {
                assert_eq!(since(&world, bus, id, settled).len(), 20, "{id:03X}");
            }
        }
    }
}

/// Verifies: ECSS 5.3.3.2.2a, 8.3.3b, 8.3.3g, 8.3.3f
#[test]
fn a_master_off_its_stub_goes_to_the_other_bus() {
    let mut world = running(MIXED, 3);
    let from = world.now();
    let master = world.index(MASTER);
    world.strike(Bus::Nominal, Fault::Disconnect(master));
    world.run_for(ms(1_000));
    assert_eq!(causes(&world, from), [SwitchCause::Isolated]);
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
}

/// Verifies: ECSS 5.3.3.2.2a, 6.5.2a, 8.3.3f
/// Notices: ECSS 5.3.3.2.2a: one silent slave makes the master leave the bus.
/// Notices: ECSS 5.3.3.2.2a: the loss of one slave ends the commands to all.
#[test]
fn a_slave_off_its_stub_is_lost_and_the_others_go_on() {
    let mut world = busy(STANDARD, 3);
    let from = world.now();
    let two = world.index(TWO);
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::Disconnect(two)));
    world.run_for(ms(2_000));
    let events = master_told(&world, from);
    assert!(events.contains(&MasterEvent::SlaveLost { node: TWO }));
    for (node, id) in [(THREE, 0x703), (FOUR, 0x704)] {
        assert!(told(&world, node, from, entered(NmtState::PreOperational)).is_empty());
        assert_eq!(between(&world, Bus::Nominal, id, from, from + ms(2_000)).len(), 20);
        let commands = executed_since(&world, node, from);
        assert!(commands >= 19, "{commands} commands in two seconds");
    }
    Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::Reconnect(two)));
    world.run_for(ms(3_000));
    assert!(world.all_operational());
}

/// Verifies: ECSS 8.3.3b
#[test]
fn a_controller_without_power_disturbs_nobody() {
    let mut world = running(STANDARD, 3);
    let from = world.now();
    let four = world.index(FOUR);
    world.strike(Bus::Nominal, Fault::PowerOff(four));
    world.run_for(ms(2_000));
    assert_eq!(world.counters(Bus::Nominal).destroyed, 0);
    // Until all nodes are on a bus where the fourth slave is heard too.
    let heartbeats = |id| between(&world, Bus::Nominal, id, from, from + ms(500)).len();
    assert_eq!([0x702, 0x703, 0x704].map(heartbeats), [5, 5, 0]);
    for node in [TWO, THREE] {
        assert!(told(&world, node, from, entered(NmtState::PreOperational)).is_empty());
    }
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
}

/// Verifies: ECSS 5.3.3.1b, 8.3.3b
#[test]
fn a_babbling_node_costs_one_bus() {
    let mut world = running(STANDARD, 3);
    let from = world.now();
    let four = world.index(FOUR);
    // The highest priority, with data that no node accepts.
    world.strike(Bus::Nominal, Fault::Babble(four, standard(0x000, &[0x55; 8])));
    world.run_for(ms(2_000));
    assert_eq!(causes(&world, from), [SwitchCause::SlavesSilent]);
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
    assert_eq!(world.command(TWO, Command::SetValue(77)), Ok(()));
    world.run_for(ms(20));
    assert_eq!(executed(&world, TWO), [77]);
}

/// Verifies: ECSS 5.3.3.1b, 8.3.3b, 8.3.3e.2
#[test]
fn a_driver_stuck_dominant_costs_one_bus() {
    let mut world = running(MIXED, 3);
    let from = world.now();
    let three = world.index(THREE);
    world.strike(Bus::Nominal, Fault::StuckDominant(three));
    world.run_for(ms(2_000));
    assert_eq!(causes(&world, from), [SwitchCause::SlavesSilent]);
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
    // When the driver is released, the bus can be used again.
    world.strike(Bus::Nominal, Fault::ReleaseDriver(three));
    world.run_for(ms(500));
    world.request(MasterRequest::SwitchBus(Bus::Nominal));
    world.run_for(ms(2_000));
    assert_eq!(world.master_bus(), Bus::Nominal);
    assert!(world.all_operational());
}

/// Verifies: ECSS 5.6.2a, 5.6.2b
#[test]
fn a_lone_master_becomes_error_passive_and_never_bus_off() {
    let mut world = MissionWorld::new(STANDARD, 0);
    world.run_until(ms(3_000));
    let port = world.port(MASTER, Bus::Nominal);
    let passive = Health { state: ErrorState::Passive, tec: 128, rec: 0, last_error: LastError::Ack };
    assert_eq!(port.health(), passive);
    let states: Vec<ErrorState> = master_told(&world, Time::ZERO)
        .into_iter()
        .filter_map(|event| match event {
            MasterEvent::Health { bus: Bus::Nominal, health } => Some(health.state),
            _ => None,
        })
        .collect();
    assert!(states.contains(&ErrorState::Passive) && !states.contains(&ErrorState::BusOff), "{states:?}");
}

/// Verifies: ECSS 5.6.2a, 5.6.2b
#[test]
fn recovery_from_bus_off_takes_128_times_11_bits() {
    let mut world = running(STANDARD, 3);
    let from = deafen_two(&mut world);
    world.run_for(ms(200));
    let log = world.log_of(TWO).into_iter().filter(|(at, _)| *at >= from);
    let states: Vec<(Time, ErrorState)> = log
        .filter_map(|(at, what)| match what {
            NodeEvent::Slave(SlaveEvent::Health { bus: Bus::Nominal, health }) => Some((at, health.state)),
            _ => None,
        })
        .collect();
    let off = states.iter().position(|(_, state)| *state == ErrorState::BusOff).expect("it went off");
    let back = states[off + 1];
    assert_eq!(back.1, ErrorState::Active);
    let away = back.0.since(states[off].0);
    let pause = Time::from_us(STANDARD.bus_off.pause.as_micros());
    assert!(away >= pause + Time::from_us(1_408), "back after {} us", away.as_us());
    // Frames of other nodes end in 11 recessive bits each.
    assert!(away <= pause + ms(20), "back after {} us", away.as_us());
}
