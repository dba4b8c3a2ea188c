//! Each node sets the acceptance filters of its controllers again, however busy its buses are (ECSS 6.10d).

use can_twin::wire::time::Time;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Bus, NodeId};
use ecss_can_worlds::NodeKey;
use ecss_can_worlds::world::World;
use mission::{STANDARD, TWO_MASTERS};

use crate::support::*;

const FIVE: NodeId = NodeId::of::<5>();
/// Each filter is set at least once in this time.
const WITHIN: Time = Time::from_ms(5_000);

/// The mission with slave 4 on one bus at a time, and a minimal slave.
const SPACECRAFT: Profile =
    Profile { selective: &[FOUR], minimal: &[MinimalNode { node: FIVE, has_heartbeat: true }], ..STANDARD };

/// Makes a running world: a master with its application, slaves 2 to 4 and a minimal one.
fn busy() -> MissionWorld {
    let mut world = MissionWorld::mixed(SPACECRAFT, 3, |world| world.seed(3));
    world.run_until(ms(2_000));
    assert!(world.all_operational());
    world
}

/// Two masters with their applications, and slaves 2 to 4.
fn pair() -> MissionWorld {
    let mut world = MissionWorld::pair(TWO_MASTERS, 3, |world| world.seed(3));
    world.run_until(ms(3_000));
    assert_eq!(world.active_masters(), [NodeKey::MASTER]);
    world
}

/// Runs the world, and asserts that a node set each filter of both controllers again in every interval.
fn assert_refreshes(world: &mut World, node: impl Into<NodeKey>) {
    let key = node.into();
    for _ in 0..2 {
        let before = Bus::ALL.map(|bus| world.port(key, bus).replaced_filters());
        world.run_for(WITHIN);
        for (bus, before) in Bus::ALL.into_iter().zip(before) {
            let after = world.port(key, bus).replaced_filters();
            assert!(!after.is_empty());
            let stale: Vec<_> = (0..after.len()).filter(|number| after[*number] == before[*number]).collect();
            assert!(stale.is_empty(), "{bus:?}: filters {stale:?} of {}", after.len());
        }
    }
}

/// Verifies: ECSS 6.10d
#[test]
fn busy_master_sets_each_filter_within_five_seconds() {
    assert_refreshes(&mut busy(), MASTER);
}

/// Verifies: ECSS 6.10d
#[test]
fn parallel_slave_sets_each_filter_within_five_seconds() {
    for slave in [TWO, THREE] {
        assert_refreshes(&mut busy(), slave);
    }
}

/// Verifies: ECSS 6.10d
#[test]
fn selective_slave_sets_each_filter_within_five_seconds() {
    assert_refreshes(&mut busy(), FOUR);
}

/// Verifies: ECSS 6.10d
#[test]
fn minimal_slave_sets_each_filter_within_five_seconds() {
    assert_refreshes(&mut busy(), FIVE);
}

/// Given two master boards, of which the second one is the standby and sends nothing.
///
/// Verifies: ECSS 6.10d
#[test]
fn both_masters_set_each_filter_within_five_seconds() {
    let mut world = pair();
    for board in [NodeKey::MASTER, NodeKey::SECOND_MASTER] {
        assert_refreshes(&mut world, board);
    }
}
