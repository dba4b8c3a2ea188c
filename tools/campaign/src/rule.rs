//! Rules that can be broken on purpose, and the scripts that may meet them.

use clap::ValueEnum;
use ecss_can::redundancy::Broken;

use crate::kind::Kind;
use crate::script::Script;

/// A rule that can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// A master that hears no slave on either bus alternates
    DeadBus,
    /// A slave does not follow every master at once
    ForeignMaster,
    /// A command that CAN delivers twice is executed once
    Repeats,
    /// Only nodes that are assigned or answer count
    UnknownNode,
    /// The master tries the other bus for a slave that is lost here and heard there
    LostMinority,
    /// A node reports another one with its Node-ID
    OneNodeId,
    /// A slave that may have been reset unheard is checked
    Unconfigured,
    /// A master that is found becomes Bdefault
    Bdefault,
    /// Of two active masters that hear each other one yields
    OneMaster,
    /// An active master says on both buses that it is active
    Claims,
}

impl Rule {
    /// What is broken in `ecss-can`; `None`: the application executes repeats.
    pub fn of_core(self) -> Option<Broken> {
        Some(match self {
            Rule::DeadBus => Broken::NoDwell,
            Rule::ForeignMaster => Broken::FollowsEverybody,
            Rule::Repeats => return None,
            Rule::UnknownNode => Broken::CountsEverybody,
            Rule::LostMinority => Broken::NeverTries,
            Rule::OneNodeId => Broken::IgnoresClash,
            Rule::Unconfigured => Broken::TrustsStarted,
            Rule::Bdefault => Broken::KeepsBdefault,
            Rule::OneMaster => Broken::NeverYields,
            Rule::Claims => Broken::NeverCalls,
        })
    }

    /// Kinds of faults that may meet it.
    fn kinds(self) -> (Kind, Option<Kind>) {
        match self {
            Rule::DeadBus => (Kind::Cut, Some(Kind::ResetMaster)),
            Rule::ForeignMaster => (Kind::Cut, Some(Kind::ForeignMaster)),
            Rule::Repeats => (Kind::Flip, None),
            Rule::UnknownNode => (Kind::UnknownNode, None),
            Rule::OneNodeId => (Kind::Clash, None),
            Rule::Unconfigured => (Kind::Cut, Some(Kind::ResetSlave)),
            Rule::LostMinority | Rule::Bdefault => (Kind::Cut, None),
            // Both boards are active only where the standby hears nothing on either bus.
            Rule::OneMaster => (Kind::Short, Some(Kind::Short)),
            Rule::Claims => (Kind::Disconnect, None),
        }
    }

    /// A random script that may meet it.
    pub fn script(self, campaign: u64, number: u64) -> Script {
        let (first, second) = self.kinds();
        let script = Script::of_kinds(campaign, number, first, second);
        if matches!(self, Rule::OneMaster | Rule::Claims) { script.with_standby() } else { script }
    }
}
