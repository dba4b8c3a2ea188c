//! Nodes of a world.

use ecss_can::redundancy::Strap;

use super::SLAVES;
use crate::master::Master;
use crate::what::What;

/// Nodes in addition to the two slaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Crew {
    /// A master without a standby.
    OneMaster,
    /// A master without a standby, with its surroundings: a boot process that checks a slave by SDO before its start,
    /// controllers of the master that go bus-off, applications, and budgets.
    OneMasterInUse,
    /// One master without assigned slaves. It learns its slaves, and one silent slave causes only a try of the other
    /// bus. Faults occur after it has identified both slaves, and no fault resets it, because it would not know a slave
    /// that it cannot hear.
    OneMasterUnassigned,
    /// Two master boards with different clocks: each receives an equal frame of the other one.
    TwoMasters,
    /// Two master boards with equal clocks: equal frames of the same moment are one frame on the wire, and neither hears it.
    TwoMastersInStep,
    /// Two master boards without assigned slaves, as with [`Crew::OneMasterUnassigned`]. Masters forget their slaves
    /// when they are reset.
    TwoMastersUnassigned,
    /// A master and one slave, whose application reports an error and a value at any moment.
    OneMasterWithReports,
    /// The same with two master boards whose clocks differ.
    TwoMastersWithReports,
}

/// The reporting slave and its surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reporter {
    /// Place of the slave: one has parallel access, one selective access.
    pub place: usize,
    /// Kind of its report.
    pub what: What,
    /// Whether another node acknowledges on both buses, even if no master receives the frames.
    pub has_witness: bool,
}

impl Reporter {
    /// Returns the place of the absent slave.
    pub(super) fn absent(self) -> usize {
        SLAVES[usize::from(self.place == SLAVES[0])]
    }
}

impl Crew {
    /// All crews.
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

    /// Returns the masters before power-on.
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

    /// Returns each slave that may report. Without reports `None`.
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

    /// Returns whether masters have a list of their slaves.
    pub(super) fn is_assigned(self) -> bool {
        !matches!(self, Crew::OneMasterUnassigned | Crew::TwoMastersUnassigned)
    }
}
