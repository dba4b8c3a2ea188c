//! Rules that can be broken on purpose, and the scripts that may show it.
//!
//! A rule is broken from outside: by a value of the profile, by frames that a node does not receive, or by the
//! application. The code of the nodes is not changed.

use std::rc::Rc;

use clap::ValueEnum;
use ecss_can::profile::Profile;
use ecss_can::types::{CobId, Duration};
use ecss_can_worlds::{Builder, NodeKey};

use crate::campaign::kind::Kind;
use crate::campaign::notes::Notes;
use crate::campaign::script::Script;

/// Value of `dwell` that is longer than any run.
const LONG_DWELL: Duration = Duration::from_millis(3_600_000);

/// A rule that can be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// A master that hears no slave on either bus alternates
    DeadBus,
    /// A command that CAN delivers twice is executed once
    Repeats,
    /// A node reports another one with its Node-ID
    OneNodeId,
    /// Of two active masters that hear each other one yields
    OneMaster,
    /// An active master says on both buses that it is active
    Claims,
}

impl Rule {
    /// Returns the profile that breaks this rule.
    pub(in crate::campaign) fn profile(self, profile: &Profile) -> Profile {
        if self == Rule::DeadBus { Profile { dwell: LONG_DWELL, ..*profile } } else { *profile }
    }

    /// Suppresses the frames that the nodes of a world need for this rule.
    pub(in crate::campaign) fn world(self, builder: Builder, script: &Script, notes: &Rc<Notes>) -> Builder {
        let masters = [NodeKey::MASTER, NodeKey::SECOND_MASTER].into_iter().take(script.masters.into());
        match self {
            Rule::DeadBus | Rule::Repeats => builder,
            Rule::OneNodeId => script.nodes().fold(builder, |builder, slave| {
                builder.misses(slave, move |frame| frame.id() == CobId::heartbeat(slave))
            }),
            Rule::OneMaster => masters.fold(builder, |builder, master| {
                let notes = notes.clone();
                builder.misses(master, move |frame| {
                    notes.is_active(master) && Profile::PAIR.claim(frame).is_some()
                })
            }),
            Rule::Claims => masters.fold(builder, |builder, master| {
                builder.misses(master, |frame| Profile::PAIR.claim(frame).is_some())
            }),
        }
    }

    /// Returns the kinds of faults that may show it.
    fn kinds(self) -> (Kind, Option<Kind>) {
        match self {
            Rule::DeadBus => (Kind::Cut, Some(Kind::ResetMaster)),
            Rule::Repeats => (Kind::Flip, None),
            Rule::OneNodeId => (Kind::Clash, None),
            // Both boards become active only if the standby receives nothing on either bus.
            Rule::OneMaster => (Kind::Short, Some(Kind::Short)),
            Rule::Claims => (Kind::Disconnect, None),
        }
    }

    /// Returns a random script that may show it.
    pub fn script(self, campaign: u64, number: u64) -> Script {
        let (first, second) = self.kinds();
        let script = Script::of_kinds(campaign, number, first, second);
        if matches!(self, Rule::OneMaster | Rule::Claims) { script.with_standby() } else { script }
    }
}
