//! Meaning of log lines.

use ecss_can::redundancy::SwitchCause;
use ecss_can::types::{Bus, NmtState, NodeId};
use ecss_can_worlds::NodeKey;

use crate::campaign::scene::News;

/// Returns the change of state in a log line; `None` if there is none.
pub fn news(key: NodeKey, text: &str) -> Option<News> {
    let is_master = key.node() == NodeId::MASTER;
    if text.contains(" starts, profile") {
        return Some(News::PowerOn);
    }
    if text.ends_with(" written") {
        return None;
    }
    Some(match text.split_once(": ") {
        Some(("active bus", rest)) if is_master => return switched(rest),
        Some(("active bus", rest)) => News::ActiveBus(named(&Bus::ALL, rest.split(' ').next()?)?),
        Some(("this master board", rest)) => News::Role(taken_over(rest)),
        Some(("clock set", _)) => News::ClockSet,
        _ if text.contains("another master") || text.contains("another node") => News::Collision,
        Some((bus, rest)) if is_master && rest.starts_with("error ") => {
            News::Hearing { bus: named(&Bus::ALL, bus)?, is_on: !rest.starts_with("error BusOff") }
        }
        _ if is_master => News::Other,
        _ => named(&STATES, text).map_or(News::Other, News::State),
    })
}

/// Parses "redundant, no longer nominal (Isolated)".
fn switched(text: &str) -> Option<News> {
    let (to, rest) = text.split_once(", no longer ")?;
    let (from, cause) = rest.trim_end_matches(')').split_once(" (")?;
    let (from, to) = (named(&Bus::ALL, from)?, named(&Bus::ALL, to)?);
    Some(News::Switched { from, to, cause: named(&CAUSES, cause)? })
}

/// Returns the bus of "Active on Nominal (Alone)"; `None` for another role.
fn taken_over(text: &str) -> Option<Bus> {
    named(&Bus::ALL, text.strip_prefix("Active on ")?.split(' ').next()?)
}

/// Returns the value with this name; case and hyphens are ignored.
fn named<T: Copy + std::fmt::Debug>(all: &[T], name: &str) -> Option<T> {
    let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "");
    all.iter().copied().find(|value| plain(&format!("{value:?}")) == plain(name))
}

const STATES: [NmtState; 4] =
    [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational];

const CAUSES: [SwitchCause; 7] = [
    SwitchCause::BusOff,
    SwitchCause::Isolated,
    SwitchCause::SlavesSilent,
    SwitchCause::Unheard,
    SwitchCause::Tried,
    SwitchCause::TriedInVain,
    SwitchCause::Commanded,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_log_are_understood() {
        let (master, second) = (NodeKey::MASTER, NodeKey::SECOND_MASTER);
        let slave = NodeKey::from(NodeId::of::<3>());
        let left =
            News::Switched { from: Bus::Nominal, to: Bus::Redundant, cause: SwitchCause::SlavesSilent };
        for (key, text, expected) in [
            (master, "master starts, profile standard", Some(News::PowerOn)),
            (slave, "slave 3 starts, profile standard", Some(News::PowerOn)),
            (master, "active bus: Redundant, no longer Nominal (SlavesSilent)", Some(left)),
            (slave, "active bus: Redundant (Followed)", Some(News::ActiveBus(Bus::Redundant))),
            (slave, "PreOperational", Some(News::State(NmtState::PreOperational))),
            (master, "Operational", Some(News::Other)),
            (second, "master starts, profile standby", Some(News::PowerOn)),
            (second, "this master board: Standby (MasterHeard)", Some(News::Role(None))),
            (
                second,
                "this master board: Active on Redundant (MasterSilent)",
                Some(News::Role(Some(Bus::Redundant))),
            ),
            (second, "active bus: Redundant, no longer Nominal (SlavesSilent)", Some(left)),
            (slave, "clock set: 7 s, was 8 s", Some(News::ClockSet)),
            (slave, "another node with this Node-ID on Nominal, yields: false", Some(News::Collision)),
            (master, "another master sends 701h on Nominal: EMCY 8150h", Some(News::Collision)),
            (
                master,
                "Nominal: error BusOff, TEC 255, REC 0, last BitDominant",
                Some(News::Hearing { bus: Bus::Nominal, is_on: false }),
            ),
            (
                master,
                "Redundant: error Passive, TEC 128, REC 0, last Ack",
                Some(News::Hearing { bus: Bus::Redundant, is_on: true }),
            ),
            (slave, "1029h:1 written", None),
            (slave, "master missed on Nominal", Some(News::Other)),
        ] {
            assert_eq!(news(key, text), expected, "{text}");
        }
    }
}
