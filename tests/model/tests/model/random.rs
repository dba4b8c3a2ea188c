//! Random faults at random moments.

use ecss_can::types::Instant;
use model::defect::Defect;
use model::property::{self, Property};
use model::watch::Watched;
use model::world::Crew;

/// Steps of a run, enough from the last fault to the end of its consequences.
const STEPS: u32 = 600;

/// Returns the first property that a run with faults at random times breaks, if there is one.
fn broken(crew: Crew, faults: u8, defect: Option<Defect>, seed: u64) -> Option<Property> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut states = Watched::all(crew, faults, defect);
    let mut state = states.swap_remove(random.usize(..states.len()));
    (0..STEPS).find_map(|_| {
        if state.world.left > 0 && random.u8(..20) == 0 {
            let mut possible = Vec::new();
            state.world.faults(Instant::ORIGIN, &mut possible);
            state.suffer(possible[random.usize(..possible.len())]);
        } else if let Some(report) = state.world.possible_report().filter(|_| random.u8(..20) == 0) {
            state.report(report);
        } else {
            state.tick();
        }
        property::ALL.into_iter().find(|property| !(property.holds)(&state))
    })
}

/// Given each crew and one to four faults at random moments, then each property holds at any time. `tests/search` visits all states
/// with up to three faults.
///
/// Verifies: ECSS 8.1a, 8.3.3f, 8.3.3g, 8.3.3i, 8.3.3l
#[test]
fn random_faults_break_no_property() {
    for seed in 0..3_000 {
        let crew = Crew::ALL[seed as usize % Crew::ALL.len()];
        let faults = 1 + (seed / Crew::ALL.len() as u64 % 4) as u8;
        assert_eq!(broken(crew, faults, None, seed), None, "{crew:?}, {faults} faults, seed {seed}");
    }
}

/// Given a defect that one fault shows, then some run breaks its property.
#[test]
fn random_faults_show_defects() {
    for (defect, crew, property) in [
        (Defect::LeavesStopped, Crew::OneMaster, property::SERVED),
        (Defect::StaysBehind, Crew::OneMaster, property::AGREED),
        (Defect::TogglesOnceMore, Crew::OneMaster, property::CTOGGLE),
        (Defect::BdefaultByToggle, Crew::OneMaster, property::BDEFAULT),
        (Defect::NeverYields, Crew::TwoMasters, property::ONE_ACTIVE),
        (Defect::NeverCalls, Crew::TwoMastersInStep, property::ONE_ACTIVE),
    ] {
        let is_found = (0..500).any(|seed| broken(crew, 1, Some(defect), seed) == Some(property));
        assert!(is_found, "{defect:?}");
    }
}
