//! Fail-over times of cuts at random instants, for a picture.

use can_twin::wire::time::Time;
use ecss_can::types::{Bus, NmtState, NodeId};
use fastrand::Rng;

use crate::campaign::flight;
use crate::campaign::host::Host;
use crate::campaign::scene::{News, Scene, Seen};
use crate::campaign::script::Script;

/// Slaves 2 to 5.
const SLAVES: u8 = 4;
/// Cuts begin within the second after this time, in microseconds.
const FROM_US: u64 = 3_000_000;
const WITHIN_US: u64 = 1_000_000;
/// Time of observation after the cut.
const WATCHED: Time = Time::from_ms(2_000);
const LOOK: Time = Time::from_ms(1);

/// Returns, for `runs` runs, the times in milliseconds from a cut of the nominal bus at `place` until the master left
/// it, and until all slaves were Operational on the other one. Runs without a fail-over are left out.
pub fn times(place: u32, runs: u64) -> Vec<[f64; 2]> {
    (0..runs).filter_map(|run| time(place, run)).collect()
}

fn time(place: u32, run: u64) -> Option<[f64; 2]> {
    let mut rng = Rng::with_seed(run);
    let at = FROM_US + rng.u64(0..WITHIN_US);
    let script = format!("run seed={run} slaves={SLAVES} length=60000000\ncut at={at} place={place}\n");
    let script: Script = script.parse().ok()?;
    let mut scene = Host::new(&script, None);
    let cut = Time::from_us(at);
    scene.run_until(cut);
    flight::begin(&mut scene, &script, 0);
    let (mut seen, mut left) = (Seen::default(), None);
    while scene.now() < cut + WATCHED {
        let next = scene.now() + LOOK;
        scene.run_until(next);
        seen.read(&mut scene);
        left = left.or_else(|| {
            let mut switches = seen.news.iter().filter(|noted| matches!(noted.news, News::Switched { .. }));
            switches.next().map(|noted| noted.at)
        });
        if let Some(left) = left
            && let Some(all) =
                (2..=SLAVES + 1).map(|node| works_from(&seen, node)).collect::<Option<Vec<_>>>()
        {
            let last = all.into_iter().max()?;
            return Some([left, last].map(|at| at.since(cut).as_secs_f64() * 1e3));
        }
    }
    None
}

/// Returns the instant since which a slave is Operational on the redundant bus.
fn works_from(seen: &Seen, node: u8) -> Option<Time> {
    let (mut state, mut bus, mut since) = (None, None, Time::ZERO);
    for noted in seen.news.iter().filter(|noted| NodeId::new(node) == Some(noted.key.node())) {
        match noted.news {
            News::State(new) => (state, since) = (Some(new), noted.at),
            News::ActiveBus(new) => (bus, since) = (Some(new), noted.at),
            _ => {}
        }
    }
    (state == Some(NmtState::Operational) && bus == Some(Bus::Redundant)).then_some(since)
}
