//! Broken rules, and the property by which each is found.

use ecss_can::redundancy::Broken;

use crate::search::property;

/// A broken rule.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// What is broken.
    pub broken: Broken,
    /// What does not hold then.
    pub property: &'static str,
    /// Faults that show it, no fewer do.
    pub faults: u8,
}

/// All of them.
pub const RULES: [Rule; 6] = [
    Rule { broken: Broken::NoDwell, property: property::SERVED, faults: 3 },
    Rule { broken: Broken::LeavesStopped, property: property::SERVED, faults: 1 },
    Rule { broken: Broken::TriesForEver, property: property::SETTLED, faults: 2 },
    Rule { broken: Broken::StaysBehind, property: property::AGREED, faults: 1 },
    Rule { broken: Broken::TogglesOnceMore, property: property::CTOGGLE, faults: 1 },
    Rule { broken: Broken::BdefaultByToggle, property: property::BDEFAULT, faults: 1 },
];
