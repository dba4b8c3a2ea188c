//! The search for all that can happen.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU8, Ordering};

use host_worlds::judge::Bounds;
use stateright::{Checker, HasDiscoveries, Model, Property};

use crate::defect::Defect;
use crate::profile::{DWELL, PAIR, PARAMETERS, TICK};
use crate::step::Step;
use crate::table::Table;
use crate::watch::Watched;
use crate::world::Crew;

/// Most faults of a search.
pub const MOST_FAULTS: u8 = 3;

/// Names of the properties.
pub mod property {
    /// Every slave in reach is operational on the master's bus.
    pub const SERVED: &str = "slaves in reach are operational within the bound";
    /// Slaves that hear the master agree with it on the bus.
    pub const AGREED: &str = "nodes that hear each other agree on the bus within the bound";
    /// The bus does not change for ever.
    pub const SETTLED: &str = "the bus does not change for ever";
    /// Two active masters.
    pub const ONE_ACTIVE: &str = "of two active masters that hear each other one yields within the bound";
    /// The role of a master does not change for ever.
    pub const ROLES: &str = "masters do not take turns for ever";
    /// Ctoggle.
    pub const CTOGGLE: &str = "Ctoggle is at most Ntoggle";
    /// Bdefault.
    pub const BDEFAULT: &str = "Bdefault changes with a find, a follow and their return only";
}

/// Largest values found, ticks and changes.
#[derive(Debug, Default)]
pub struct Longest {
    unserved: AtomicU8,
    disagreeing: AtomicU8,
    needless: AtomicU8,
    rivalling: AtomicU8,
    handed_over: AtomicU8,
}

/// A model of a spacecraft.
#[derive(Debug)]
pub struct Spacecraft {
    crew: Crew,
    faults: u8,
    defect: Option<Defect>,
    longest: Longest,
}

fn bounds() -> Bounds {
    Bounds::new(&PARAMETERS, DWELL, &PAIR)
}

fn ticks(span: ecss_can::types::Duration) -> u8 {
    u8::try_from(span.as_micros() / TICK.as_micros()).unwrap_or(u8::MAX)
}

fn note(longest: &AtomicU8, value: u8) -> u8 {
    longest.fetch_max(value, Ordering::Relaxed);
    value
}

impl Model for Spacecraft {
    type State = Watched;
    type Action = Step;

    fn init_states(&self) -> Vec<Watched> {
        vec![Watched::new(self.crew, self.faults, self.defect)]
    }

    fn actions(&self, state: &Watched, actions: &mut Vec<Step>) {
        actions.push(Step::Tick);
        if state.world.left > 0 {
            actions.push(Step::Calm);
            let mut faults = Vec::new();
            state.world.faults(&mut faults);
            actions.extend(faults.into_iter().map(Step::Fault));
        }
    }

    fn next_state(&self, last: &Watched, action: Step) -> Option<Watched> {
        let mut next = last.clone();
        match action {
            Step::Tick => next.tick(),
            Step::Fault(fault) => next.suffer(fault),
            Step::Calm => next.world.left = 0,
        }
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(property::SERVED, |model: &Spacecraft, state: &Watched| {
                note(&model.longest.unserved, state.watch.unserved) <= ticks(bounds().service)
            }),
            Property::always(property::AGREED, |model: &Spacecraft, state: &Watched| {
                note(&model.longest.disagreeing, state.watch.disagreeing) <= ticks(bounds().agreement)
            }),
            Property::always(property::SETTLED, |model: &Spacecraft, state: &Watched| {
                note(&model.longest.needless, state.watch.needless) <= Bounds::NEEDLESS
            }),
            Property::always(property::ONE_ACTIVE, |model: &Spacecraft, state: &Watched| {
                note(&model.longest.rivalling, state.watch.rivalling) <= ticks(bounds().rivalry)
            }),
            Property::always(property::ROLES, |model: &Spacecraft, state: &Watched| {
                note(&model.longest.handed_over, state.watch.handed_over) <= Bounds::HANDED_OVER
            }),
            Property::always(property::CTOGGLE, |_, state: &Watched| !state.watch.is_toggled_too_often),
            Property::always(property::BDEFAULT, |_, state: &Watched| !state.watch.has_wrong_bdefault),
        ]
    }
}

/// A whole search.
#[derive(Debug)]
pub struct Report {
    /// Different states.
    pub states: usize,
    /// Steps from one state to another, also to known ones.
    pub steps: usize,
    /// Every state that can be reached was looked at, from power-on to where nothing new happens.
    pub is_closed: bool,
    /// Longest time without service, milliseconds.
    pub unserved: u64,
    /// Longest disagreement, milliseconds.
    pub disagreeing: u64,
    /// Most changes of the bus while the slaves were served.
    pub needless: u8,
    /// Longest time with two active masters that hear each other, milliseconds.
    pub rivalling: u64,
    /// Most changes of role after the last fault.
    pub handed_over: u8,
    /// Properties that do not hold, and the shortest way there.
    pub violations: Vec<Violation>,
}

/// A property does not hold.
#[derive(Debug)]
pub struct Violation {
    /// Its name.
    pub property: &'static str,
    /// The way there.
    pub table: String,
    /// Steps of it.
    pub steps: usize,
    /// Faults on it.
    pub faults: usize,
}

/// Searches through all that can happen with up to `faults` faults at any moment. Ends at the first state without a property
/// that does not hold, if there is one.
pub fn search(crew: Crew, faults: u8, threads: usize) -> Report {
    explore(crew, faults, None, threads, HasDiscoveries::Any)
}

/// Searches for the shortest way on which `property` does not hold with a defect.
pub fn find(crew: Crew, faults: u8, defect: Defect, property: &'static str) -> Option<Violation> {
    let until = HasDiscoveries::AllOf(BTreeSet::from([property]));
    let report = explore(crew, faults, Some(defect), 1, until);
    report.violations.into_iter().find(|violation| violation.property == property)
}

fn explore(crew: Crew, faults: u8, defect: Option<Defect>, threads: usize, until: HasDiscoveries) -> Report {
    let model = Spacecraft { crew, faults, defect, longest: Longest::default() };
    let checker = model.checker().threads(threads).finish_when(until).spawn_bfs().join();
    let longest = &checker.model().longest;
    let millis = |ticks: &AtomicU8| u64::from(ticks.load(Ordering::Relaxed)) * TICK.as_millis();
    let violations: Vec<Violation> = checker
        .discoveries()
        .into_iter()
        .map(|(property, path)| violation(property, Table::new(path)))
        .collect();
    Report {
        states: checker.unique_state_count(),
        steps: checker.state_count(),
        is_closed: checker.is_done() && violations.is_empty(),
        unserved: millis(&longest.unserved),
        disagreeing: millis(&longest.disagreeing),
        needless: longest.needless.load(Ordering::Relaxed),
        rivalling: millis(&longest.rivalling),
        handed_over: longest.handed_over.load(Ordering::Relaxed),
        violations,
    }
}

fn violation(property: &'static str, table: Table) -> Violation {
    let is_fault = |(_, step): &&(Watched, Option<Step>)| matches!(step, Some(Step::Fault(_)));
    let (steps, faults) = (table.0.len() - 1, table.0.iter().filter(is_fault).count());
    Violation { property, table: table.to_string(), steps, faults }
}
