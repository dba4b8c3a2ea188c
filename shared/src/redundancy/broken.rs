//! Rules that are broken on purpose: the model checker or the campaign of faults must find every one.

/// A rule that does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Broken {
    /// The master stays where it hears no slave, for ever.
    NoDwell,
    /// The master does not start slaves that somebody else stopped.
    LeavesStopped,
    /// The master tries the other bus again and again for the same slaves.
    TriesForEver,
    /// A slave that follows the master does not go to its bus.
    StaysBehind,
    /// A search has a switch too many.
    TogglesOnceMore,
    /// Each switch of a search changes Bdefault.
    BdefaultByToggle,
    /// Of two active masters none yields.
    NeverYields,
    /// An active master does not say that it is active.
    NeverCalls,
    /// Every node that was heard counts as a slave.
    CountsEverybody,
    /// The master does not try the other bus for a few lost slaves.
    NeverTries,
    /// A slave that was started once is not checked when it waits again.
    TrustsStarted,
    /// A slave follows every message of a master to the other bus at once.
    FollowsEverybody,
    /// A master that is found does not become Bdefault.
    KeepsBdefault,
    /// A slave takes no notice of another node with its Node-ID.
    IgnoresClash,
}
