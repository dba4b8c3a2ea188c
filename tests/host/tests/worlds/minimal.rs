//! Minimal slaves (ECSS 9) beside full ones, with and without a heartbeat, and the cut of a bus.

use can_twin::wire::time::Time;
use ecss_can::node::MasterEvent;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Bus, NodeId};
use ecss_can_worlds::World;
use ecss_can_worlds::world::Sent;
use mission::STANDARD;

use crate::support::*;

/// Minimal slave that sends a heartbeat.
const HEARD: NodeId = NodeId::of::<5>();
/// Minimal slave without heartbeat on both buses. The next one is on one bus at a time.
const SILENT: NodeId = NodeId::of::<6>();
const SILENT_SELECTIVE: NodeId = NodeId::of::<7>();
const MINIMAL: [NodeId; 3] = [HEARD, SILENT, SILENT_SELECTIVE];

const SPACECRAFT: Profile = Profile {
    minimal: &[
        MinimalNode { node: HEARD, has_heartbeat: true },
        MinimalNode { node: SILENT, has_heartbeat: false },
        MinimalNode { node: SILENT_SELECTIVE, has_heartbeat: false },
    ],
    selective: &[THREE, SILENT_SELECTIVE],
    ..STANDARD
};

const CUT: Time = Time::from_ms(1_035);
const END: Time = Time::from_ms(4_050);

/// Returns a world whose master sends commands and requests to all slaves ten times a second. Slaves 2 and 3 are full
/// ones.
fn flown() -> MissionWorld {
    let mut world = MissionWorld::mixed(SPACECRAFT, 2, |world| world.seed(7));
    world.run_until(CUT);
    assert!(world.all_operational());
    assert_eq!(world.master_bus(), Bus::Nominal);
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_until(END);
    world
}

/// Returns the number of commands to a node that ended on a bus up to `to` while the node was there.
fn commanded(world: &World, node: NodeId, bus: Bus, from: Time, to: Time) -> usize {
    between(world, bus, 0x300 + u16::from(node.get()), from, to).len()
}

/// Returns the number of executed commands in the last answer of a node to SYNC on the redundant bus, and the time of
/// the answer.
fn executed(world: &World, node: NodeId) -> (usize, Time) {
    let frames = since(world, Bus::Redundant, 0x280 + u16::from(node.get()), CUT);
    let last = frames.last().expect("it answers SYNC on the redundant bus");
    let [a, b, c, d, _] = last.frame.payload().try_into().unwrap();
    (u32::from_le_bytes([a, b, c, d]) as usize, last.start)
}

/// Returns the time at which a minimal slave changed to the redundant bus.
fn moved(world: &World, node: NodeId) -> Time {
    let first = since(world, Bus::Redundant, 0x280 + u16::from(node.get()), CUT);
    first.first().expect("it answers SYNC on the redundant bus").start
}

/// Verifies: ECSS 9.4.9.1.1a, 8.3.3b, 8.3.3e.2
/// Notices: ECSS 9.4.9.1.1a: a slave without a heartbeat of its own does not follow the master.
#[test]
fn full_and_minimal_slaves_fly_the_cut_of_a_bus() {
    let world = flown();
    assert_eq!(world.master_bus(), Bus::Redundant);
    assert!(world.all_operational());
    assert_eq!(switches(&world, Time::ZERO), 1);
    for node in [HEARD, SILENT] {
        // The master has moved at 105 ms at the latest, and the next SYNC comes within 100 ms.
        assert!(moved(&world, node) < CUT + ms(210), "{node:?}");
    }
    // Twice the consumer time of 250 ms, and the next SYNC.
    let toggled = moved(&world, SILENT_SELECTIVE);
    assert!((CUT + ms(450)..CUT + ms(650)).contains(&toggled), "{} us", toggled.as_us());
}

/// Given slaves with and without heartbeat, then each command that reached a slave was executed once.
///
/// Verifies: ECSS 9.4.2a, 9.4.3b.2, 9.4.1a
#[test]
fn commands_before_and_after_the_cut_are_executed_once() {
    let world = flown();
    for node in [HEARD, SILENT] {
        let (executed, until) = executed(&world, node);
        let nominal = commanded(&world, node, Bus::Nominal, Time::ZERO, until);
        let redundant = commanded(&world, node, Bus::Redundant, Time::ZERO, until);
        assert!(nominal >= 8 && redundant >= 25, "{node:?}: {nominal}, {redundant}");
        assert_eq!(executed, nominal + redundant, "{node:?}");
    }
    let (executed, until) = executed(&world, SILENT_SELECTIVE);
    let nominal = commanded(&world, SILENT_SELECTIVE, Bus::Nominal, Time::ZERO, until);
    let here = commanded(&world, SILENT_SELECTIVE, Bus::Redundant, moved(&world, SILENT_SELECTIVE), until);
    let all = commanded(&world, SILENT_SELECTIVE, Bus::Redundant, Time::ZERO, until);
    // It may have changed the bus up to one SYNC, and thus one command, before its first answer.
    assert!((nominal + here..=nominal + here + 1).contains(&executed), "{executed}, {nominal}, {here}");
    assert!(all >= here + 3, "those sent while it searched are lost: {all}, {here}");
}

/// Given a master that sends every request of the mission in turn, then each request that a minimal slave knows brings telemetry with
/// its code, and no other one brings any.
///
/// Verifies: ECSS 9.4.3a, 9.4.3b.1, 9.4.1a, 9.4.2b, 9.4.3b
#[test]
fn each_request_that_reaches_a_minimal_slave_brings_telemetry() {
    let world = flown();
    for (node, from) in [(HEARD, CUT), (SILENT, CUT), (SILENT_SELECTIVE, moved(&world, SILENT_SELECTIVE))] {
        let id = u16::from(node.get());
        let until = END - ms(2);
        let requests = between(&world, Bus::Redundant, 0x400 + id, from, until);
        assert!(requests.len() >= 20, "{node:?}: {}", requests.len());
        // Uptime, value, commands executed: three of ten.
        let known = requests.into_iter().filter(|sent| matches!(sent.frame.payload(), [1..=3, 1, ..]));
        let known: Vec<Sent> = known.collect();
        assert!(known.len() >= 6, "{node:?}: {}", known.len());
        let telemetry = between(&world, Bus::Redundant, 0x380 + id, known[0].end, END);
        assert_eq!(telemetry.len(), known.len(), "{node:?}");
        assert!(telemetry.iter().zip(&known).all(|(telemetry, request)| {
            telemetry.frame.payload()[..2] == request.frame.payload()[..2] && telemetry.start >= request.end
        }));
    }
}

/// Given slaves that send no heartbeat, then the master assigns them to no bus by it, and neither misses nor identifies
/// them.
///
/// Verifies: ECSS 9.4.9.2a
#[test]
fn slaves_without_heartbeat_are_neither_missed_nor_asked() {
    let world = flown();
    for bus in [Bus::Nominal, Bus::Redundant] {
        for id in [0x706, 0x707, 0x605, 0x606, 0x607] {
            assert_eq!(since(&world, bus, id, Time::ZERO).len(), 0, "{id:03X}h");
        }
    }
    let heartbeats = since(&world, Bus::Redundant, 0x705, Time::ZERO);
    assert!(heartbeats.len() >= 28 && heartbeats.iter().all(|sent| sent.frame.payload() == [0x05]));
    let missed = |event: &MasterEvent| match event {
        MasterEvent::SlaveLost { node } | MasterEvent::SlaveUnheard { node, .. } => MINIMAL.contains(node),
        _ => false,
    };
    assert!(!master_told(&world, Time::ZERO).iter().any(missed));
}

/// Given a silent slave that loses its power for a second, then it executes the first command after that without being
/// started.
///
/// Verifies: ECSS 9.4.6.1a, 9.4.1a
#[test]
fn silent_slave_takes_commands_again_after_a_loss_of_power() {
    let mut world = MissionWorld::mixed(SPACECRAFT, 2, |world| world);
    world.run_until(ms(1_035));
    world.power_off(SILENT);
    world.run_until(ms(2_035));
    world.power_on(SILENT);
    let on = world.now();
    world.run_until(ms(2_550));
    let answers = since(&world, Bus::Nominal, 0x286, on);
    let [a, b, c, d, _] = answers.last().unwrap().frame.payload().try_into().unwrap();
    let until = answers.last().unwrap().start;
    let commands = between(&world, Bus::Nominal, 0x306, on, until).len();
    assert_eq!(u32::from_le_bytes([a, b, c, d]) as usize, commands);
    assert!(commands >= 4, "{commands}");
    assert_eq!(between(&world, Bus::Nominal, 0x286, ms(1_036), on).len(), 0);
    let sent = between(&world, Bus::Nominal, 0x306, ms(1_035), on).len();
    assert!((9..=11).contains(&sent), "the master goes on: {sent}");
}
