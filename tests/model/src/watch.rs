//! A world observed by [`ecss_can_worlds::judge`].

use ecss_can::redundancy::Parameters;
use ecss_can::types::{Bus, Canonical, Instant, PerBus};
use ecss_can_worlds::judge::{self, Command, Slave, View, Watch};

use crate::defect::Defect;
use crate::profile::{PARAMETERS, without_round};
use crate::station::Station;
use crate::world::{Crew, Fault, MASTERS, Report, World};

/// An observed spacecraft at [`Instant::ORIGIN`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Watched {
    /// The spacecraft.
    pub world: World,
    /// The properties.
    pub watch: Watch,
    /// Consecutive ticks in which the master of a reachable slave did not know its reports.
    pub unknown: u8,
}

impl Watched {
    /// Returns spacecraft with all nodes powered at the same instant: one, or one per slave that may report. `defect`:
    /// a broken rule.
    pub fn all(crew: Crew, faults: u8, defect: Option<Defect>) -> Vec<Watched> {
        let watched = |reporter| Watched {
            world: World::new(crew, reporter, faults, defect),
            watch: Watch::default(),
            unknown: 0,
        };
        crew.reporters().into_iter().map(watched).collect()
    }

    /// Returns the first one of [`all`](Watched::all), the only one without reports.
    pub fn new(crew: Crew, faults: u8, defect: Option<Defect>) -> Watched {
        Watched::all(crew, faults, defect).swap_remove(0)
    }

    /// Applies a fault and its immediate consequences.
    pub fn suffer(&mut self, fault: Fault) {
        self.suffer_at(fault, Instant::ORIGIN);
        self.world.canonical(Instant::ORIGIN, &());
    }

    /// Applies a fault at any time, without the shift to [`Instant::ORIGIN`].
    pub fn suffer_at(&mut self, fault: Fault, now: Instant) {
        self.world.suffer_at(fault, now, &mut |world| restart(&mut self.watch, world));
        restart(&mut self.watch, &self.world);
        self.unknown = 0;
    }

    /// Applies a report of the slave and its immediate consequences.
    pub fn report(&mut self, report: Report) {
        self.report_at(report, Instant::ORIGIN);
        self.world.canonical(Instant::ORIGIN, &());
    }

    /// Applies a report at any time, without the shift to [`Instant::ORIGIN`].
    pub fn report_at(&mut self, report: Report, now: Instant) {
        self.world.report_at(report, now, &mut |world| restart(&mut self.watch, world));
        self.unknown = 0;
    }

    /// Returns the ticks until the next due action.
    pub fn ticks(&self) -> u32 {
        self.world.ticks_from(Instant::ORIGIN)
    }

    /// Advances time to the next tick with a due action.
    pub fn tick(&mut self) {
        let now = self.tick_from(Instant::ORIGIN);
        self.world.canonical(now, &());
    }

    /// Advances time from any time, without the shift to [`Instant::ORIGIN`]. Returns the new time.
    pub fn tick_from(&mut self, now: Instant) -> Instant {
        let ticks = self.world.ticks_from(now);
        let now = self.world.tick_from(now, &mut |world| restart(&mut self.watch, world));
        look(&mut self.watch, &self.world, ticks);
        let is_calm = self.world.left == 0 && self.world.reports == 0 && !self.world.is_losing();
        let is_unknown = is_calm && with_view(&self.world, |view| is_unknown(view, &self.world));
        let before = self.unknown;
        self.unknown = if is_unknown { before.saturating_add(ticks as u8) } else { 0 };
        if self.world.has_rounds() && before < without_round() && self.unknown >= without_round() {
            self.world.begin_round(now);
        }
        now
    }
}

/// Calls `judge` with the nodes of a world and their connections.
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
            access: node.access(),
            has_given_up: node.has_given_up(),
            parameters: Some(Parameters { ntoggle: PARAMETERS.ntoggle, ..*node.parameters() }),
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

/// Returns whether the master does not know a report of a reachable slave.
fn is_unknown(view: &View, world: &World) -> bool {
    let Command::One(master) = view.command() else { return false };
    (0..2).any(|slave| view.is_in_reach(master, slave)) && !world.is_known_by(master)
}

/// Restarts the bounds after a fault.
fn restart(watch: &mut Watch, world: &World) {
    with_view(world, |view| watch.restart(view));
}

/// Checks the world after `ticks`. Times count when no further fault is possible.
fn look(watch: &mut Watch, world: &World, ticks: u32) {
    watch.has_wrong_bdefault |= world.slaves.iter().any(|slave| slave.has_wrong_bdefault());
    with_view(world, |view| {
        watch.note(view);
        if world.left == 0 && !world.is_losing() {
            let are_rivals = Bus::ALL.into_iter().any(|bus| view.are_rivals_on(bus));
            watch.count(view, are_rivals, ticks as u8);
        }
    });
}
