//! A shift of the clock keeps all that decisions depend on.

use ecss_can::redundancy::{RoleChange, SwitchCause};
use ecss_can::types::{Bus, Frame, Instant, NmtState};
use model::profile::TICK;
use model::station::Station;
use model::watch::Watched;
use model::world::{Crew, World};

type MasterSeen = (Bus, Option<SwitchCause>, Option<RoleChange>, bool);
type Seen = (Vec<MasterSeen>, [(Bus, NmtState, bool, Bus); 2], Vec<Option<Frame>>);

/// Observable behaviour of a node.
fn seen(world: &World) -> Seen {
    let slaves = world.slaves.each_ref().map(|slave| {
        let bdefault = slave.parameters().bdefault;
        (slave.active(), slave.state(), slave.has_given_up(), bdefault)
    });
    let masters = world.masters.iter().map(|it| (it.active(), it.switched, it.role_changed, it.is_active()));
    let mut nodes: Vec<&dyn Station> = vec![&world.slaves[0], &world.slaves[1]];
    nodes.extend(world.masters.iter().map(|master| master as &dyn Station));
    let waiting = nodes.iter().flat_map(|node| Bus::ALL.map(|bus| node.waiting().next(bus))).collect();
    (masters.collect(), slaves, waiting)
}

/// Given two equal worlds and the same random faults, ten in 20 s. When the clock of one is shifted to the origin after
/// each step, and old state is dropped, then both behave equally at the same time.
#[test]
fn a_world_relative_to_now_does_what_an_absolute_one_does() {
    for seed in 0..5_000 {
        let crew = Crew::ALL[seed as usize % Crew::ALL.len()];
        let mut random = fastrand::Rng::with_seed(seed);
        let (mut relative, mut absolute) = (Watched::new(crew, 10, None), Watched::new(crew, 10, None));
        let mut now = Instant::ORIGIN;
        for step in 0..200 {
            if relative.world.left > 0 && random.u8(..20) == 0 {
                let mut faults = Vec::new();
                relative.world.faults(Instant::ORIGIN, &mut faults);
                let fault = faults[random.usize(..faults.len())];
                relative.suffer(fault);
                absolute.suffer_at(fault, now);
            } else {
                let ticks = relative.ticks();
                relative.tick();
                let next = absolute.tick_from(now);
                assert_eq!(next, now + TICK.times(ticks), "seed {seed}, step {step}");
                now = next;
            }
            assert_eq!(seen(&relative.world), seen(&absolute.world), "seed {seed}, step {step}");
            assert_eq!(relative.watch, absolute.watch, "seed {seed}, step {step}");
        }
    }
}
