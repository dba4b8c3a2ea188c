//! Rules that tests break on purpose. The model checker or the fault campaign must find every one.

use crate::types::Canonical;

/// Rule that is broken on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Broken {
    /// The master stays without a limit on a bus where it hears no slave.
    NoDwell,
    /// The master does not start slaves that another node stopped.
    LeavesStopped,
    /// The master tries the other bus repeatedly for the same slaves.
    TriesForEver,
    /// A slave that follows the master does not change to its bus.
    StaysBehind,
    /// A search makes one switch too many.
    TogglesOnceMore,
    /// Each switch of a search changes Bdefault.
    BdefaultByToggle,
    /// Neither of two active masters yields.
    NeverYields,
    /// An active master sends no claims.
    NeverCalls,
    /// Every node that was heard counts as a slave.
    CountsEverybody,
    /// The master does not try the other bus for a few lost slaves.
    NeverTries,
    /// A slave that was started once is not checked when it waits again.
    TrustsStarted,
    /// A slave follows every message of a master to the other bus at once.
    FollowsEverybody,
    /// The bus on which the master was found does not become Bdefault.
    KeepsBdefault,
    /// A slave ignores another node with its Node-ID.
    IgnoresClash,
}
