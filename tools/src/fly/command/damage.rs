//! Faults of one bus that the operator has caused and not repaired.

use std::collections::BTreeMap;
use std::fmt;

use can_twin::wire::frame::WireFrame;

use super::{Level, Payload};
use crate::images::support::node::Node;

/// Faults of one bus. Positions are metres from the master's end.
#[derive(Debug, Default)]
pub struct Damage {
    /// Breaks of the cable, ascending.
    pub cuts: Vec<f64>,
    /// Shorts of the cable; at one position the last one counts.
    pub shorts: Vec<(f64, Level)>,
    /// Frame that a board sends whenever the bus is free.
    pub babbling: BTreeMap<Node, WireFrame>,
}

impl Damage {
    /// Returns whether the cable is broken at a position; `None`: anywhere.
    pub fn is_cut(&self, metres: Option<f64>) -> bool {
        metres.map_or(!self.cuts.is_empty(), |metres| self.cuts.contains(&metres))
    }

    /// Adds a break of the cable.
    pub fn cut(&mut self, metres: f64) {
        self.cuts.push(metres);
        self.cuts.sort_by(f64::total_cmp);
    }

    /// Removes the break at a position, or all breaks.
    pub fn heal(&mut self, metres: Option<f64>) {
        self.cuts.retain(|cut| metres.is_some_and(|metres| *cut != metres));
    }

    /// Returns the short of the piece of cable at this position: of several, the last one.
    pub fn short_of_piece(&self, metres: f64) -> Option<(f64, Level)> {
        let piece = |metres: f64| self.cuts.partition_point(|cut| *cut <= metres);
        self.shorts.iter().rev().find(|(at, _)| piece(*at) == piece(metres)).copied()
    }

    /// Adds a short that holds the bus at a level.
    pub fn short(&mut self, metres: f64, level: Level) {
        self.shorts.retain(|(at, _)| *at != metres);
        self.shorts.push((metres, level));
    }
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cuts = self.cuts.iter().map(|metres| format!("cut at {metres} m"));
        let shorts = self.shorts.iter().map(|(metres, level)| format!("short at {metres} m, {level}"));
        let babbling =
            self.babbling.iter().map(|(node, frame)| format!("node {node} babbles {}", Payload(*frame)));
        let all: Vec<String> = cuts.chain(shorts).chain(babbling).collect();
        if all.is_empty() { f.write_str("no fault") } else { f.write_str(&all.join("; ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_listed_until_they_are_repaired() {
        let mut damage = Damage::default();
        assert_eq!(damage.to_string(), "no fault");
        damage.cut(3.5);
        damage.cut(1.0);
        damage.short(0.0, Level::Dominant);
        damage.short(0.0, Level::Recessive);
        damage.babbling.insert(2, WireFrame::standard(0x080, &[1]));
        let all = "cut at 1 m; cut at 3.5 m; short at 0 m, recessive; node 2 babbles 080#01";
        assert_eq!(damage.to_string(), all);
        damage.heal(Some(1.0));
        damage.shorts.clear();
        damage.babbling.clear();
        assert_eq!(damage.to_string(), "cut at 3.5 m");
        damage.heal(None);
        assert!(!damage.is_cut(None));
    }
}
