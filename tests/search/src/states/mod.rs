//! The search of all states of a small spacecraft.

pub mod evidence;
pub mod snapshot;
pub mod step;
pub mod table;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use ecss_can::types::Instant;
use model::defect::Defect;
use model::profile::TICK;
use model::property::{AGREED, BDEFAULT, CTOGGLE, KNOWN, ONE_ACTIVE, ROLES, SERVED, SETTLED};
use model::watch::Watched;
use model::world::{Crew, Fault};
use stateright::{Checker, HasDiscoveries, Model, Property};
use step::Step;
use table::Table;

/// Largest number of faults of a search.
pub const MOST_FAULTS: u8 = 3;

/// Largest values found, ticks and changes.
#[derive(Debug, Default)]
pub struct Longest {
    unserved: AtomicU8,
    disagreeing: AtomicU8,
    needless: AtomicU8,
    rivalling: AtomicU8,
    handed_over: AtomicU8,
    unknown: AtomicU8,
}

/// A model of a spacecraft.
#[derive(Debug)]
pub struct Spacecraft {
    start: Watched,
    longest: Arc<Longest>,
}

impl Longest {
    fn note(&self, state: &Watched) {
        let Watched { watch, unknown, .. } = state;
        for (longest, value) in [
            (&self.unserved, watch.unserved),
            (&self.disagreeing, watch.disagreeing),
            (&self.needless, watch.needless),
            (&self.rivalling, watch.rivalling),
            (&self.handed_over, watch.handed_over),
            (&self.unknown, *unknown),
        ] {
            longest.fetch_max(value, Ordering::Relaxed);
        }
    }
}

impl Model for Spacecraft {
    type State = Watched;
    type Action = Step;

    fn init_states(&self) -> Vec<Watched> {
        vec![self.start.clone()]
    }

    fn actions(&self, state: &Watched, actions: &mut Vec<Step>) {
        actions.push(Step::Tick);
        actions.extend(state.world.possible_report().map(Step::Report));
        if state.world.left > 0 {
            let mut faults = Vec::new();
            state.world.faults(Instant::ORIGIN, &mut faults);
            actions.extend(faults.into_iter().map(Step::Fault));
        }
        if state.world.left > 0 || state.world.reports > 0 {
            actions.push(Step::Calm);
        }
    }

    fn next_state(&self, last: &Watched, action: Step) -> Option<Watched> {
        let mut next = last.clone();
        match action {
            Step::Tick => next.tick(),
            Step::Fault(fault) => next.suffer(fault),
            Step::Report(report) => next.report(report),
            Step::Calm => (next.world.left, next.world.reports) = (0, 0),
        }
        Some(next)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always(SERVED.name, |model: &Spacecraft, state: &Watched| {
                model.longest.note(state);
                (SERVED.holds)(state)
            }),
            Property::always(AGREED.name, |_, state: &Watched| (AGREED.holds)(state)),
            Property::always(SETTLED.name, |_, state: &Watched| (SETTLED.holds)(state)),
            Property::always(ONE_ACTIVE.name, |_, state: &Watched| (ONE_ACTIVE.holds)(state)),
            Property::always(ROLES.name, |_, state: &Watched| (ROLES.holds)(state)),
            Property::always(CTOGGLE.name, |_, state: &Watched| (CTOGGLE.holds)(state)),
            Property::always(BDEFAULT.name, |_, state: &Watched| (BDEFAULT.holds)(state)),
            Property::always(KNOWN.name, |_, state: &Watched| (KNOWN.holds)(state)),
        ]
    }
}

/// Result of a search.
#[derive(Debug)]
pub struct Report {
    /// Different states.
    pub states: usize,
    /// Steps from one state to another, also to known ones.
    pub steps: usize,
    /// Whether all reachable states were visited.
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
    /// Longest time in which a master did not know what a slave had reported, milliseconds.
    pub unknown: u64,
    /// Properties that do not hold, with the shortest path to each.
    pub violations: Vec<Violation>,
}

/// A state in which a property does not hold.
#[derive(Debug)]
pub struct Violation {
    /// Its name.
    pub property: &'static str,
    /// Path to the state.
    pub table: String,
    /// Number of its steps.
    pub steps: usize,
    /// Number of its faults.
    pub faults: usize,
}

/// Searches all states with up to `faults` faults at any time. Ends at the first state in which a property does not
/// hold, if there is one.
pub fn search(crew: Crew, faults: u8, threads: usize) -> Report {
    explore(crew, &[], faults, None, threads, HasDiscoveries::Any)
}

/// Searches for the shortest path to a state in which `property` does not hold with a defect. `before`: faults that
/// exist from power-on.
pub fn find(
    crew: Crew,
    before: &'static [Fault],
    faults: u8,
    defect: Defect,
    property: &'static str,
) -> Option<Violation> {
    let until = HasDiscoveries::AllOf(BTreeSet::from([property]));
    let report = explore(crew, before, faults, Some(defect), 1, until);
    report.violations.into_iter().find(|violation| violation.property == property)
}

fn explore(
    crew: Crew,
    before: &'static [Fault],
    faults: u8,
    defect: Option<Defect>,
    threads: usize,
    until: HasDiscoveries,
) -> Report {
    let longest = Arc::new(Longest::default());
    let (mut states, mut steps, mut is_closed, mut violations) = (0, 0, true, Vec::new());
    // One after the other, for the memory.
    for mut start in Watched::all(crew, faults + before.len() as u8, defect) {
        before.iter().for_each(|fault| start.suffer(*fault));
        let model = Spacecraft { start, longest: longest.clone() };
        let checker = model.checker().threads(threads).finish_when(until.clone()).spawn_bfs().join();
        states += checker.unique_state_count();
        steps += checker.state_count();
        is_closed &= checker.is_done();
        let found = checker.discoveries().into_iter();
        violations.extend(found.map(|(property, path)| violation(property, Table::new(path))));
    }
    let millis = |ticks: &AtomicU8| u64::from(ticks.load(Ordering::Relaxed)) * TICK.as_millis();
    Report {
        states,
        steps,
        is_closed: is_closed && violations.is_empty(),
        unserved: millis(&longest.unserved),
        disagreeing: millis(&longest.disagreeing),
        needless: longest.needless.load(Ordering::Relaxed),
        rivalling: millis(&longest.rivalling),
        handed_over: longest.handed_over.load(Ordering::Relaxed),
        unknown: millis(&longest.unknown),
        violations,
    }
}

fn violation(property: &'static str, table: Table) -> Violation {
    let is_fault = |(_, step): &&(Watched, Option<Step>)| matches!(step, Some(Step::Fault(_)));
    let (steps, faults) = (table.0.len() - 1, table.0.iter().filter(is_fault).count());
    Violation { property, table: table.to_string(), steps, faults }
}
