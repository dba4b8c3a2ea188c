//! Random faults: after the end of all faults, all slaves become Operational on the bus of the master.

use ecss_can::node::MasterRequest;
use ecss_can::profile::Profile;
use ecss_can::types::{Bus, NodeId};
use ecss_can_worlds::world::World;
use mission::STANDARD;
use proptest::prelude::*;

use crate::random::cases;
use crate::support::*;

/// A profile in which slave 4 never gives up. After giving up, it might stay on a bus without a master.
const PATIENT: Profile = Profile { ntoggle: 255, selective: &[FOUR], ..STANDARD };

#[derive(Clone, Copy, Debug)]
enum Step {
    Wait { ms: u64 },
    Cut { bus: Bus, position_m: f64 },
    Heal { bus: Bus },
    Reset { node: NodeId },
    Off { node: NodeId },
    On { node: NodeId },
    Switch { to: Bus },
}

fn step() -> impl Strategy<Value = Step> {
    let bus = || prop::sample::select(&Bus::ALL[..]);
    let node = || prop::sample::select(&[MASTER, TWO, THREE, FOUR][..]);
    // Between neighbours: node n sits at 2 n metres.
    let cut =
        (bus(), 1_u8..4).prop_map(|(bus, left)| Step::Cut { bus, position_m: f64::from(left) * 2.0 + 1.0 });
    prop_oneof![
        4 => (0..1_500_u64).prop_map(|ms| Step::Wait { ms }),
        3 => cut,
        2 => bus().prop_map(|bus| Step::Heal { bus }),
        2 => node().prop_map(|node| Step::Reset { node }),
        1 => node().prop_map(|node| Step::Off { node }),
        1 => node().prop_map(|node| Step::On { node }),
        1 => bus().prop_map(|to| Step::Switch { to }),
    ]
}

fn perform(world: &mut World, step: Step) {
    match step {
        Step::Wait { ms: span } => world.run_for(ms(span)),
        Step::Cut { bus, position_m } => world.cut(bus, position_m),
        Step::Heal { bus } => world.heal(bus),
        Step::Reset { node } => world.reset(node),
        Step::Off { node } => world.power_off(node),
        Step::On { node } => world.power_on(node),
        Step::Switch { to } if world.is_powered(MASTER) => world.request(MasterRequest::SwitchBus(to)),
        Step::Switch { .. } => {}
    }
}

proptest! {
    #![proptest_config(cases(32))]

    /// Verifies: ECSS 8.3.3f
    #[test]
    fn everybody_is_operational_after_everything_is_healed(
        seed in any::<u64>(),
        script in prop::collection::vec(step(), 1..16),
    ) {
        let mut world = MissionWorld::of(PATIENT, 3, |world| world.seed(seed));
        world.run_until(ms(500));
        for step in script {
            perform(&mut world, step);
        }
        Bus::ALL.into_iter().for_each(|bus| world.heal(bus));
        [MASTER, TWO, THREE, FOUR].into_iter().for_each(|node| world.power_on(node));
        world.run_for(ms(6_000));
        prop_assert!(world.all_operational());
        // The state is stable.
        let settled = world.now();
        world.run_for(ms(1_000));
        prop_assert!(world.all_operational());
        prop_assert_eq!(switches(&world, settled), 0);
    }
}
