//! Outages of a part of the network under traffic: the other nodes communicate at all times, not only at the end.
//!
//! The master commands every slave and asks it for telemetry ten times a second. Heartbeat and SYNC have the same period.

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::boot::{AssignedSlave, Expected};
use ecss_can::link::port::{CanPort, ErrorState, Health};
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, NmtState, NodeId};
use ecss_can_worlds::log::NodeEvent;
use ecss_can_worlds::world::World;
use mission::STANDARD;

use crate::support::*;

/// Period of commands, telemetry, heartbeats and SYNC.
const PERIOD: Time = Time::from_ms(100);
/// Duration of frames that may be sent first, and the delay of late heartbeats.
const JITTER_US: u64 = 2_000;

/// Makes a network with continuous commands and telemetry.
fn busy(profile: Profile) -> MissionWorld {
    let mut world = MissionWorld::busy(profile, 3, |world| world);
    world.run_until(ms(1_000));
    assert!(world.all_operational());
    world
}

/// Returns the commands that a slave executed in `(from, to]`: time, and turn of the master.
fn executed(world: &MissionWorld, node: NodeId, from: Time, to: Time) -> Vec<(Time, u32)> {
    turns(world, node).into_iter().filter(|(at, _)| *at > from && *at <= to).collect()
}

/// Asserts that this slave and the master were undisturbed from `from` to `to` on the nominal bus.
fn assert_undisturbed(world: &MissionWorld, node: NodeId, from: Time, to: Time) {
    let expected = to.since(from).as_us() / PERIOD.as_us();
    let commands = executed(world, node, from, to);
    assert!(commands.len() as u64 + 1 >= expected, "{node:?}: {} of {expected}", commands.len());
    for pair in commands.windows(2) {
        assert_eq!(pair[1].1, pair[0].1 + 1, "{node:?} executes each command");
        let gap = pair[1].0.since(pair[0].0).as_us();
        assert!(gap.abs_diff(PERIOD.as_us()) < JITTER_US, "{node:?}: {gap} us");
    }
    let own = u16::from(node.get());
    // Its heartbeat, telemetry and local time; heartbeat and SYNC of the master.
    for id in [0x700 + own, 0x380 + own, 0x180 + own, 0x701, 0x080] {
        let frames = between(world, Bus::Nominal, id, from, to);
        assert!(frames.len() as u64 + 1 >= expected, "{id:03X}: {} of {expected}", frames.len());
        let periods = periods_us(&frames);
        assert!(periods.iter().all(|us| us.abs_diff(PERIOD.as_us()) < JITTER_US), "{id:03X}: {periods:?}");
    }
    assert_eq!(told(world, node, from, entered(NmtState::PreOperational)), [], "{node:?}");
}

/// Offsets from the start of a heartbeat of slave 2, and the number of interrupted frames. Twice the heartbeat is on
/// the wire, then the bus is idle.
const MOMENTS: [(Time, usize); 3] = [(Time::from_us(10), 1), (Time::from_us(40), 1), (Time::from_ms(53), 0)];

/// Returns the start of the first heartbeat of slave 2 after one second. It is the same in each such world.
fn next_heartbeat() -> Time {
    let mut world = busy(STANDARD);
    let from = world.now();
    world.run_for(ms(150));
    since(&world, Bus::Nominal, 0x702, from)[0].start
}

/// Given a busy network, when a slave loses its power, in the middle of a frame of its own or between frames, then the
/// others get each command, send each telemetry, heartbeat and local time in time, and stay on the bus. The same holds
/// when it returns.
///
/// Verifies: ECSS 5.3.3.2.2b, 6.5.2a, 6.9d, 8.3.3a, 8.3.3d
/// Notices: ECSS 5.3.3.2.2b: one silent slave makes the master leave the bus.
#[test]
fn others_go_on_while_a_slave_has_no_power() {
    let heartbeat = next_heartbeat();
    for (moment, torn) in MOMENTS {
        let mut world = busy(STANDARD);
        world.run_until(heartbeat + moment);
        let off = world.now();
        world.power_off(TWO);
        world.run_for(ms(2_000));
        assert_eq!(world.torn_frames(Bus::Nominal), torn, "{} us", moment.as_us());
        assert!(master_told(&world, off).contains(&MasterEvent::SlaveLost { node: TWO }));
        let on = world.now();
        world.power_on(TWO);
        world.run_for(ms(2_000));
        let returned = MasterEvent::SlaveReturned { node: TWO, bus: Bus::Nominal };
        assert!(master_told(&world, on).contains(&returned));
        for node in [THREE, FOUR] {
            assert_undisturbed(&world, node, off, world.now());
        }
        assert_undisturbed(&world, TWO, on + ms(500), world.now());
        assert!(world.all_operational());
        assert_eq!((switches(&world, off), world.frames(Bus::Redundant).len()), (0, 0));
    }
}

/// A profile in which the network waits at power-on for slave 2 before it starts SYNC.
const MANDATORY: Profile = Profile {
    slaves: &[AssignedSlave {
        node: TWO,
        mandatory: true,
        expected: Expected { device_type: 0, identity: [0; 4], stamp: [0; 2] },
    }],
    ..STANDARD
};

/// Given a busy network, when a mandatory slave loses its power, then the others continue in the same way, and SYNC
/// does not wait for it again. When it returns, then it is started.
///
/// Verifies: ECSS 5.3.3.2.2b, 5.3.3.2.3k, 5.3.3.2.3k.1, 6.9d, 8.3.3d
/// Notices: ECSS 5.3.3.2.2b: SYNC waits again when a mandatory slave is lost.
/// Notices: ECSS 5.3.3.2.3k: SYNC ends when a mandatory slave behind the cut is lost.
#[test]
fn others_go_on_while_a_mandatory_slave_has_no_power() {
    let mut world = busy(MANDATORY);
    let off = world.now();
    world.power_off(TWO);
    world.run_for(ms(2_000));
    assert!(master_told(&world, off).contains(&MasterEvent::SlaveLost { node: TWO }));
    for node in [THREE, FOUR] {
        assert_undisturbed(&world, node, off, world.now());
    }
    world.power_on(TWO);
    world.run_for(ms(2_000));
    assert!(world.all_operational());
    assert_eq!((switches(&world, off), world.frames(Bus::Redundant).len()), (0, 0));
}

/// The harness between slaves 2 and 3: the master and slave 2 are upstream of it.
const CUT_M: f64 = 5.0;

/// Given a busy network, when both wires of the nominal bus are interrupted between slaves, then those upstream communicate there
/// until the master leaves for the other bus, and on that one afterwards: no command is lost.
///
/// Verifies: ECSS 5.3.3.2.3k, 5.3.3.2.3k.1, 8.3.3b, 8.3.3g
#[test]
fn nodes_upstream_of_a_cut_communicate_until_the_bus_is_left() {
    let mut world = busy(STANDARD);
    let cut = world.now();
    world.cut(Bus::Nominal, CUT_M);
    while switches(&world, cut) == 0 {
        world.run_for(ms(1));
    }
    let left = world.now() - ms(1);
    assert!(
        left.since(cut) >= ms(140),
        "a consumer time after the last heartbeat: {} us",
        left.since(cut).as_us()
    );
    assert_undisturbed(&world, TWO, cut, left);
    world.run_for(ms(2_000));
    let values: Vec<u32> =
        executed(&world, TWO, cut, world.now()).into_iter().map(|(_, value)| value).collect();
    assert_eq!(values, (values[0]..).take(values.len()).collect::<Vec<_>>(), "each command once");
    assert!(values.len() >= 21, "{}", values.len());
    assert_eq!((world.master_bus(), switches(&world, cut)), (Bus::Redundant, 1));
    assert!(world.all_operational());
}

/// Given a busy network, when both buses are interrupted at one place, then the slave upstream gets commands in every second of the
/// cut. When both are healed, then all slaves communicate as before: no error state, no node that was reset, no further move.
///
/// Verifies: ECSS 5.3.3.2.3k, 5.3.3.2.3k.1, 5.3.3.2.3k.2, 8.3.3d, 8.3.3f
/// Notices: ECSS 5.3.3.2.3k.1: a slave that follows the master to the other bus becomes Pre-operational.
/// Notices: ECSS 5.3.3.2.3k: the master starts slaves at their boot-up alone.
#[test]
fn a_cut_of_both_buses_leaves_no_ill_effects_when_it_heals() {
    let outages = [300, 1_000, 5_000].into_iter();
    // All slaves on both buses, or slave 4 on one at a time.
    for (outage, profile) in outages.flat_map(|outage| [(outage, STANDARD), (outage, MIXED)]) {
        let mut world = busy(profile);
        let cut = world.now();
        Bus::ALL.into_iter().for_each(|bus| world.cut(bus, CUT_M));
        world.run_for(ms(outage));
        for second in 0..outage / 1_000 {
            let begin = cut + ms(1_000 * second);
            let commands = executed(&world, TWO, begin, begin + ms(1_000)).len();
            assert!(commands >= 8, "{commands} commands in second {second}");
        }
        assert!(told(&world, TWO, cut, entered(NmtState::PreOperational)).is_empty());
        assert_eq!(switches(&world, cut), 1, "the other bus is no better, and the master stays there");
        Bus::ALL.into_iter().for_each(|bus| world.heal(bus));
        world.run_for(ms(3_000));
        let settled = world.now();
        world.run_for(ms(1_000));
        assert_eq!(switches(&world, settled), 0);
        for node in [TWO, THREE, FOUR] {
            assert_settled(&world, node, settled);
        }
    }
}

/// Asserts that a slave receives and sends all expected frames after `settled`, and that its controllers have no
/// errors.
fn assert_settled(world: &MissionWorld, node: NodeId, settled: Time) {
    let commands = executed(world, node, settled, world.now()).len();
    assert!((9..=11).contains(&commands), "{node:?}: {commands} commands");
    let own = u16::from(node.get());
    let bus = world.master_bus();
    for id in [0x700 + own, 0x380 + own, 0x180 + own] {
        let frames = since(world, bus, id, settled).len();
        assert!((9..=11).contains(&frames), "{id:03X}: {frames}");
    }
    // Error active, no error count left, and no restart since the cut.
    assert_eq!(world.port(node, bus).health().state, ErrorState::Active);
    assert_eq!(world.port(node, bus).health(), Health::default(), "{node:?}");
    let log = world.log_of(node).into_iter().filter(|(at, _)| *at >= settled);
    let unusual: Vec<_> = log.filter(|(_, what)| !is_routine(what)).collect();
    assert!(unusual.is_empty(), "{node:?}: {unusual:?}");
    assert_eq!(boots(world, node), 1, "{node:?} was not reset");
}

/// Returns whether an event is one of normal operation: heartbeats of the master, SYNC, PDOs and times.
fn is_routine(node_event: &NodeEvent) -> bool {
    use SlaveEvent::{Heartbeat, Pdo, Sync, Time};
    matches!(node_event, NodeEvent::Slave(Heartbeat { .. } | Sync { .. } | Pdo(_) | Time(_)))
}

/// Returns the number of boot-up messages of a slave on both buses.
fn boots(world: &World, node: NodeId) -> usize {
    let id = 0x700 + u16::from(node.get());
    let of = |bus| since(world, bus, id, Time::ZERO).into_iter().filter(|sent| sent.frame.payload() == [0]);
    Bus::ALL.into_iter().map(|bus| of(bus).count()).sum()
}

/// Applies a short with this level to both buses of a busy network, for a few milliseconds up to more than the search
/// of the slaves. Asserts that after it all nodes communicate as before: each command is executed once, no error state
/// and no error count is left, no node was reset, and the master stays on its bus.
fn assert_short_leaves_no_ill_effects(level: bool) {
    for (span, profile) in
        [3, 60, 400, 3_000, 40_000].into_iter().flat_map(|span| [(span, STANDARD), (span, MIXED)])
    {
        let mut world = busy(profile);
        let struck = world.now();
        Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::Short { position_m: CUT_M, level }));
        world.run_for(ms(span));
        for node in [TWO, THREE, FOUR] {
            let late = executed(&world, node, struck + ms(1), world.now());
            assert!(late.is_empty(), "{node:?} hears nothing: {late:?}");
        }
        Bus::ALL.into_iter().for_each(|bus| world.strike(bus, Fault::ClearShorts));
        world.run_for(ms(6_000));
        let settled = world.now();
        world.run_for(ms(1_000));
        assert!(world.all_operational(), "after {span} ms");
        assert_eq!(switches(&world, settled), 0, "after {span} ms");
        assert_eq!(world.port(MASTER, world.master_bus()).health(), Health::default());
        for node in [TWO, THREE, FOUR] {
            assert_settled(&world, node, settled);
            let values = executed(&world, node, Time::ZERO, world.now());
            assert!(
                values.windows(2).all(|pair| pair[0].1 < pair[1].1),
                "{node:?} executes each command once"
            );
        }
    }
}

/// Given CAN_H at ground, CAN_L at CAN_H, CAN_H at a negative voltage or CAN_L at a positive one, then the differential
/// voltage is zero or negative.
///
/// Verifies: ECSS 5.3.3.2.3d, 5.3.3.2.3g, 5.3.3.2.3h, 5.3.3.2.3j, 5.6.2a
/// Notices: ECSS 5.3.3.2.3g: a bus with too many recoveries from bus-off is never tried again.
/// Notices: ECSS 5.3.3.2.3j: the master starts slaves at their boot-up alone.
#[test]
fn buses_that_were_shorted_recessive_resume() {
    assert_short_leaves_no_ill_effects(true);
}

/// Given CAN_H at a positive voltage or CAN_L at a negative one, then the differential voltage is that of a dominant
/// bit.
///
/// Verifies: ECSS 5.3.3.2.3d, 5.3.3.2.3h, 5.3.3.2.3g, 5.3.3.2.3j, 8.3.3f
/// Notices: ECSS 5.3.3.2.3d: the master starts slaves at their boot-up alone.
/// Notices: ECSS 5.3.3.2.3h: the master starts slaves at their boot-up alone.
#[test]
fn buses_that_were_shorted_dominant_resume() {
    assert_short_leaves_no_ill_effects(false);
}
