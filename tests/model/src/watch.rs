//! The world as [`judge`] sees it.

use ecss_can::redundancy::Parameters;
use ecss_can::types::{Bus, PerBus};
use judge::{Slave, View, Watch};

use crate::profile::PARAMETERS;
use crate::station::Station;
use crate::world::{MASTERS, World};

/// Calls `judge` with the nodes of a world, and which of them a bus joins.
fn with_view<R>(world: &World, judge: impl FnOnce(&View) -> R) -> R {
    let mut masters = [judge::Master::default(); judge::MASTERS];
    for ((seen, master), place) in masters.iter_mut().zip(&world.masters).zip(MASTERS) {
        *seen = judge::Master {
            is_powered: world.is_powered(place),
            bus: master.is_active().then(|| master.active()),
            has_switched: master.switched.is_some(),
            has_changed_role: master.role_changed.is_some(),
        };
    }
    let slaves = [0, 1].map(|index| {
        let (node, place) = (&world.slaves[index], index + 1);
        let joins = |master, bus| world.is_connected(bus, master) && world.is_connected(bus, place);
        Slave {
            is_powered: world.is_powered(place),
            state: node.state(),
            bus: Some(node.active()),
            access: node.access,
            has_given_up: node.has_given_up,
            parameters: Some(Parameters { ntoggle: PARAMETERS.ntoggle, ..*node.selector.parameters() }),
            wired: MASTERS.map(|master| PerBus::from_fn(|bus| joins(master, bus))),
        }
    });
    let joins_masters = |bus| MASTERS.into_iter().all(|place| world.is_connected(bus, place));
    judge(&View {
        masters: &masters[..world.masters.len()],
        slaves: &slaves,
        joins_masters: PerBus::from_fn(joins_masters),
    })
}

/// A fault happened.
pub fn restart(watch: &mut Watch, world: &World) {
    with_view(world, |view| watch.restart(view));
}

/// Looks at the world after `ticks`. Times count when no fault can happen any more.
pub fn look(watch: &mut Watch, world: &World, ticks: u32) {
    watch.has_wrong_bdefault |= world.slaves.iter().any(|slave| slave.has_wrong_bdefault);
    with_view(world, |view| {
        watch.note(view);
        if world.left == 0 && !world.is_losing() {
            let are_rivals = Bus::ALL.into_iter().any(|bus| view.are_rivals_on(bus));
            watch.count(view, are_rivals, ticks as u8);
        }
    });
}
