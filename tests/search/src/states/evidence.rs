//! The property by which each defect is found.

use model::defect::Defect;
use model::property::{self, Property};
use model::world::Crew;

use super::Violation;

/// What shows a defect.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    defect: Defect,
    property: Property,
    crew: Crew,
    /// Number of faults that it takes, 1 to 3. Fewer show nothing.
    pub faults: u8,
}

impl Evidence {
    /// Returns what shows this defect.
    pub fn of(defect: Defect) -> Evidence {
        let (property, faults, crew) = match defect {
            Defect::NoDwell => (property::SERVED, 3, Crew::OneMaster),
            Defect::LeavesStopped => (property::SERVED, 1, Crew::OneMaster),
            Defect::StaysBehind => (property::AGREED, 1, Crew::OneMaster),
            Defect::TogglesOnceMore => (property::CTOGGLE, 1, Crew::OneMaster),
            Defect::BdefaultByToggle => (property::BDEFAULT, 1, Crew::OneMaster),
            Defect::NeverYields => (property::ONE_ACTIVE, 1, Crew::TwoMasters),
            Defect::NeverCalls => (property::ONE_ACTIVE, 1, Crew::TwoMastersInStep),
        };
        Evidence { defect, property, crew, faults }
    }

    /// Searches with up to `faults` faults for the shortest way on which the property does not hold.
    pub fn search(&self, faults: u8) -> Option<Violation> {
        super::find(self.crew, faults, self.defect, self.property.name)
    }
}
