//! Who is there.

use ecss_can::redundancy::Strap;

use crate::master::Master;

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
}

impl Crew {
    /// All of them.
    pub const ALL: [Crew; 6] = [
        Crew::OneMaster,
        Crew::OneMasterInUse,
        Crew::OneMasterUnassigned,
        Crew::TwoMasters,
        Crew::TwoMastersInStep,
        Crew::TwoMastersUnassigned,
    ];

    /// Masters before power-on.
    pub(super) fn masters(self) -> Vec<Master> {
        let straps = match self {
            Crew::OneMaster | Crew::OneMasterInUse | Crew::OneMasterUnassigned => vec![None],
            _ => vec![Some(Strap::Prime), Some(Strap::Second)],
        };
        let (is_assigned, has_boot) = (self.is_assigned(), self == Crew::OneMasterInUse);
        straps.into_iter().map(|strap| Master::new(strap, is_assigned, has_boot)).collect()
    }

    /// Whether masters have a list of their slaves.
    pub(super) fn is_assigned(self) -> bool {
        !matches!(self, Crew::OneMasterUnassigned | Crew::TwoMastersUnassigned)
    }
}
