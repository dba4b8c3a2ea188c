//! Broken rules, and the property by which each is found.

use ecss_can::redundancy::Broken;

use crate::search::property;
use crate::world::Crew;

/// A broken rule.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// What is broken.
    pub broken: Broken,
    /// What does not hold then.
    pub property: &'static str,
    /// Faults that show it, no fewer do.
    pub faults: u8,
    /// Who manages the network.
    pub crew: Crew,
}

/// All of them.
pub const RULES: [Rule; 8] = [
    Rule { broken: Broken::NoDwell, property: property::SERVED, faults: 3, crew: Crew::OneMaster },
    Rule { broken: Broken::LeavesStopped, property: property::SERVED, faults: 1, crew: Crew::OneMaster },
    Rule { broken: Broken::TriesForEver, property: property::SETTLED, faults: 2, crew: Crew::OneMaster },
    Rule { broken: Broken::StaysBehind, property: property::AGREED, faults: 1, crew: Crew::OneMaster },
    Rule { broken: Broken::TogglesOnceMore, property: property::CTOGGLE, faults: 1, crew: Crew::OneMaster },
    Rule { broken: Broken::BdefaultByToggle, property: property::BDEFAULT, faults: 1, crew: Crew::OneMaster },
    Rule { broken: Broken::NeverYields, property: property::ONE_ACTIVE, faults: 1, crew: Crew::TwoMasters },
    Rule {
        broken: Broken::NeverCalls,
        property: property::ONE_ACTIVE,
        faults: 1,
        crew: Crew::TwoMastersInStep,
    },
];
