//! Parallel access: each bus has a controller of its own in every node (ECSS 8.2.2).
//!
//! Verifies: ECSS 8.2.1a.2

use can_twin::wire::fault::Fault;
use can_twin::wire::time::Time;
use ecss_can::link::port::{CanPort, ErrorState, Health};
use ecss_can::types::{Bus, NmtState};
use mission::STANDARD;

use crate::support::*;

/// A start command to node 100, which does not exist: each slave receives and ignores it.
const TO_NOBODY: [u8; 2] = [1, 100];

/// A network that is busy on the nominal bus, while a foreign node sends on the redundant one every millisecond: a command to a
/// node that does not exist, and a heartbeat of node 100, which the master receives.
fn loaded(span_ms: u64) -> MissionWorld {
    let mut world = MissionWorld::busy(STANDARD, 3, |world| world);
    world.run_until(ms(1_000));
    assert!(world.all_operational());
    for _ in 0..span_ms {
        world.inject(Bus::Redundant, standard(0x000, &TO_NOBODY));
        world.inject(Bus::Redundant, standard(0x764, &[0x05]));
        world.run_for(ms(1));
    }
    world
}

/// Given traffic on both buses at the same time, then each node receives all frames of both: slaves the commands of the foreign node, the
/// master its heartbeats. Traffic on the nominal bus stays as it was.
///
/// Verifies: ECSS 8.2.2a, 8.3.3d
/// Notices: ECSS 8.2.2a: at power-on only the controller of the active bus joins.
#[test]
fn each_node_receives_from_both_buses_at_the_same_time() {
    const SPAN: u64 = 1_000;
    let world = loaded(SPAN);
    let from = ms(1_000);
    let nominal = world.frames(Bus::Nominal).iter().filter(|sent| sent.end > from);
    let overlaps = |start: Time, end: Time| {
        world.frames(Bus::Redundant).iter().any(|other| other.start < end && other.end > start)
    };
    let together = nominal.filter(|sent| overlaps(sent.start, sent.end)).count();
    assert!(together >= 20, "{together} frames of the nominal bus while the other one was busy");
    for node in world.slaves() {
        let counters = world.status(node).counters;
        assert_eq!(u64::from(counters.redundant.received), SPAN, "{node:?}");
        assert_eq!((counters.nominal.lost, counters.redundant.lost), (0, 0));
        assert!(told(&world, node, from, entered(NmtState::PreOperational)).is_empty());
        let executed = executed_since(&world, node, from);
        assert!((9..=11).contains(&executed), "{node:?} obeys on the nominal bus");
    }
    let counters = world.status(MASTER).counters;
    assert!(u64::from(counters.redundant.received) >= SPAN, "{}", counters.redundant.received);
    // No node of the network sends on the bus that is not active.
    assert!(world.frames(Bus::Redundant).iter().all(|sent| sent.node.is_none()));
    // The bus that is not active is acknowledged by all four nodes.
    assert!(world.frames(Bus::Redundant).iter().all(|sent| sent.receivers == 4));
    assert_eq!(switches(&world, from), 0);
}

/// Given a busy nominal bus, when the redundant one is shorted for a second, then the controllers of the nominal bus
/// count no error, and no frame there is late.
///
/// Verifies: ECSS 8.2.2a
#[test]
fn a_short_of_one_bus_is_not_seen_by_controllers_of_other() {
    let mut world = MissionWorld::busy(STANDARD, 3, |world| world);
    world.run_until(ms(1_000));
    let from = world.now();
    world.strike(Bus::Redundant, Fault::Short { position_m: 4.0, level: false });
    world.run_for(ms(1_000));
    for node in [MASTER, TWO, THREE, FOUR] {
        assert_eq!(world.port(node, Bus::Nominal).health(), Health::default(), "{node:?}");
        assert_eq!(world.status(node).health.nominal.state, ErrorState::Active);
    }
    assert_eq!(world.counters(Bus::Nominal).destroyed, 0);
    for id in [0x701, 0x080, 0x702, 0x703, 0x704, 0x382, 0x383, 0x384] {
        let frames = between(&world, Bus::Nominal, id, from, world.now());
        let periods = periods_us(&frames);
        assert!(
            frames.len() >= 9 && periods.iter().all(|us| us.abs_diff(100_000) < 2_000),
            "{id:03X}: {periods:?}"
        );
    }
    assert_eq!(switches(&world, from), 0);
    assert!(world.all_operational());
}
