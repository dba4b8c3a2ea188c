//! The largest number of slaves of a spacecraft: Node-IDs 2 to 126 with one master. 127 is that of maintenance mode.

use ecss_can::node::MasterEvent;
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, Duration, NmtState, NodeId};
use mission::STANDARD;

use crate::support::*;

/// Node-IDs 2 to 126.
const SLAVES: u8 = 125;

/// Few frames per slave, because there are many slaves.
const SLOW: Profile = Profile {
    heartbeat: Duration::from_millis(400),
    consumer: Duration::from_millis(1_000),
    sync: Duration::from_millis(5_000),
    ..STANDARD
};

/// Given 125 slaves, when the nominal bus is cut next to the master, then all of them are started before, stay
/// Operational, and follow it; the master has identified each, and loses none.
///
/// Verifies: ECSS 8.3.3b, 8.3.3d, 8.3.3g
#[test]
fn master_runs_125_slaves_and_all_follow_it_over_a_cut() {
    let mut world = MissionWorld::of(SLOW, SLAVES, |world| world.seed(5));
    world.run_until(ms(1_200));
    assert_eq!(world.slaves().len(), usize::from(SLAVES));
    assert!(world.all_operational());
    for node in (2..=126).map(|raw| NodeId::new(raw).unwrap()) {
        let answers = since(&world, Bus::Nominal, 0x580 + u16::from(node.get()), ms(0));
        assert!(!answers.is_empty(), "node {} answered no SDO", node.get());
        assert_eq!(world.master(|master| master.slave_state(node)), Some(NmtState::Operational));
    }
    let cut = world.now();
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_for(ms(1_000));
    assert_eq!((world.master_bus(), switches(&world, cut)), (Bus::Redundant, 1));
    assert!(world.all_operational());
    assert!(
        world
            .slaves()
            .into_iter()
            .all(|node| told(&world, node, cut, entered(NmtState::PreOperational)).is_empty())
    );
    let lost =
        master_told(&world, ms(0)).into_iter().filter(|event| matches!(event, MasterEvent::SlaveLost { .. }));
    assert_eq!(lost.count(), 0);
    let beats = since(&world, Bus::Redundant, 0x77E, cut);
    assert!((1..=3).contains(&beats.len()), "node 126 sends its heartbeat: {}", beats.len());
}
