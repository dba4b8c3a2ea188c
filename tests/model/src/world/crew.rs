//! Who is there.

use ecss_can::redundancy::Strap;

use super::SLAVES;
use crate::master::Master;
use crate::what::What;

/// Who is there beside the two slaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Crew {
    /// A master without a standby.
    OneMaster,
    /// The same, with what is around: a boot process that checks a slave by SDO before it starts it, controllers of the master that go
    /// bus-off, applications, and budgets.
    OneMasterInUse,
    /// One master, and no slave is assigned: it learns who its slaves are, and one of them alone does not move it, but for a try.
    /// Faults happen after it has asked both slaves, and none resets it: it would not know a slave that it cannot hear.
    OneMasterUnassigned,
    /// Two master boards. Their clocks differ: of equal frames that both send, each hears that of the other one.
    TwoMasters,
    /// Two master boards with equal clocks: equal frames of the same moment are one frame on the wire, and neither hears it.
    TwoMastersInStep,
    /// The same, and no slave is assigned, as with [`Crew::OneMasterUnassigned`]. Masters forget their slaves when they are reset.
    TwoMastersUnassigned,
    /// A master and one slave, whose application reports an error and a value at any moment.
    OneMasterWithReports,
    /// The same with two master boards whose clocks differ.
    TwoMastersWithReports,
}

/// The slave that reports, and what is around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reporter {
    /// Place of the slave: one has parallel access, one selective access.
    pub place: usize,
    /// What it reports.
    pub what: What,
    /// Another node acknowledges on both buses, also where no master hears the slave.
    pub has_witness: bool,
}

impl Reporter {
    /// Place of the slave that is not there.
    pub(super) fn absent(self) -> usize {
        SLAVES[usize::from(self.place == SLAVES[0])]
    }
}

impl Crew {
    /// All of them.
    pub const ALL: [Crew; 8] = [
        Crew::OneMaster,
        Crew::OneMasterInUse,
        Crew::OneMasterUnassigned,
        Crew::TwoMasters,
        Crew::TwoMastersInStep,
        Crew::TwoMastersUnassigned,
        Crew::OneMasterWithReports,
        Crew::TwoMastersWithReports,
    ];

    /// Masters before power-on.
    pub(super) fn masters(self) -> Vec<Master> {
        let straps = match self {
            Crew::OneMaster
            | Crew::OneMasterInUse
            | Crew::OneMasterUnassigned
            | Crew::OneMasterWithReports => vec![None],
            _ => vec![Some(Strap::Prime), Some(Strap::Second)],
        };
        let (is_assigned, has_boot) = (self.is_assigned(), self == Crew::OneMasterInUse);
        straps.into_iter().map(|strap| Master::new(strap, is_assigned, has_boot)).collect()
    }

    /// Each slave that may be the one that reports. Without reports `None`.
    pub fn reporters(self) -> Vec<Option<Reporter>> {
        if !matches!(self, Crew::OneMasterWithReports | Crew::TwoMastersWithReports) {
            return vec![None];
        }
        let mut all = Vec::new();
        for (place, what) in SLAVES.into_iter().flat_map(|place| [(place, What::Error), (place, What::Value)])
        {
            all.extend([false, true].map(|has_witness| Some(Reporter { place, what, has_witness })));
        }
        all
    }

    /// Whether masters have a list of their slaves.
    pub(super) fn is_assigned(self) -> bool {
        !matches!(self, Crew::OneMasterUnassigned | Crew::TwoMastersUnassigned)
    }
}
