//! The property by which each defect is found.

use ecss_can::types::Bus;
use model::defect::Defect;
use model::property::{self, Property};
use model::world::{Crew, Fault, MASTERS};

use super::Violation;

/// Evidence of a defect.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    defect: Defect,
    property: Property,
    crew: Crew,
    /// Faults that exist from power-on.
    before: &'static [Fault],
    /// Number of further faults that are needed to show the defect.
    pub faults: u8,
}

impl Evidence {
    /// Returns the evidence of this defect.
    pub fn of(defect: Defect) -> Evidence {
        let (property, faults, crew) = match defect {
            Defect::NoDwell => (property::SERVED, 2, Crew::OneMaster),
            Defect::LeavesStopped => (property::SERVED, 1, Crew::OneMaster),
            Defect::StaysBehind => (property::AGREED, 1, Crew::OneMaster),
            Defect::TogglesOnceMore => (property::CTOGGLE, 1, Crew::OneMaster),
            Defect::BdefaultByToggle => (property::BDEFAULT, 1, Crew::OneMaster),
            Defect::NeverYields => (property::ONE_ACTIVE, 1, Crew::TwoMasters),
            Defect::NeverCalls => (property::ONE_ACTIVE, 1, Crew::TwoMastersInStep),
            Defect::NeverAnnounces => (property::KNOWN, 1, Crew::OneMasterWithReports),
            Defect::NeverReads => (property::KNOWN, 1, Crew::OneMasterWithReports),
        };
        // A dead bus from the start. With this fault among the searched ones there are fifty times as many states.
        let before: &[Fault] =
            if defect == Defect::NoDwell { &[Fault::Cut(Bus::Nominal, MASTERS[0])] } else { &[] };
        Evidence { defect, property, crew, before, faults }
    }

    /// Searches with up to `faults` faults for the shortest path to a state in which the property does not hold.
    pub fn search(&self, faults: u8) -> Option<Violation> {
        super::find(self.crew, self.before, faults, self.defect, self.property.name)
    }
}
