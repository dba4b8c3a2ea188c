//! What is under way to the nodes of a segment: level changes of drivers, and disturbances.
//!
//! Of many drivers that change at almost the same time a node notices the first that goes dominant and the last that goes
//! recessive. Only these two are events; the others are taken in with the next one.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::calendar::Earliest;
use crate::controller::NodeIndex;
use crate::fault::Effect;
use crate::fine::Fine;
use crate::mac::DOMINANT;
use crate::node::Drivers;

/// A change that reaches a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Arrival {
    pub(crate) at: Fine,
    pub(crate) node: NodeIndex,
    pub(crate) change: Change,
}

/// What changes at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Change {
    /// A driver goes to this level.
    Driver(bool, NodeIndex),
    /// A disturbance begins.
    GlitchBegins(Effect),
    /// It ends.
    GlitchEnds(Effect),
}

/// What is under way to the nodes of a segment.
#[derive(Clone, Debug, Default)]
pub(crate) struct Arrivals {
    /// Of each node.
    lines: Vec<Line>,
    /// When the first of them has other drivers than none, or none any more.
    turns: Earliest,
    glitches: BinaryHeap<Reverse<Arrival>>,
    /// When the last level change that is under way has arrived.
    last: Option<Fine>,
}

/// Level changes of drivers on their way to one node.
#[derive(Clone, Debug, Default)]
struct Line {
    /// When, the level, whose. Equal instants: what makes a line dominant comes first, so that a hand-over between two drivers
    /// is no pulse.
    pending: Vec<(Fine, bool, NodeIndex)>,
    /// The earliest of them.
    first: Option<Fine>,
    /// Drivers that go recessive.
    ending: Drivers,
}

/// The next thing that happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// The drivers that a node sees begin or end to be dominant.
    Turn(NodeIndex),
    /// A disturbance.
    Glitch,
    /// All is there that was under way.
    Last,
}

impl Line {
    /// Takes in what has arrived at `until`.
    fn take_in(&mut self, until: Fine, seen: &mut Drivers) {
        if self.first.is_none_or(|first| first > until) {
            return;
        }
        self.pending.sort_unstable();
        let arrived = self.pending.partition_point(|&(at, ..)| at <= until);
        for (_, level, driver) in self.pending.drain(..arrived) {
            note(seen, level, driver);
        }
        self.survey();
    }

    fn survey(&mut self) {
        self.first = self.pending.iter().map(|&(at, ..)| at).min();
        let ends = self.pending.iter().filter(|(_, level, _)| *level != DOMINANT);
        self.ending = ends.fold(0, |ending, &(.., driver)| ending | 1 << driver);
    }

    /// When there is a dominant driver where none was, or none any more.
    fn turn(&self, seen: Drivers) -> Fine {
        let mut begins = self.pending.iter().filter(|(_, level, _)| *level == DOMINANT).peekable();
        if seen == 0 {
            return begins.map(|&(at, ..)| at).min().unwrap_or(Fine::NEVER);
        }
        if seen & !self.ending != 0 {
            return Fine::NEVER;
        }
        if begins.peek().is_none() {
            // Each of them ends, and none begins.
            let ends = self.pending.iter().filter(|(.., driver)| seen >> driver & 1 == 1);
            return ends.map(|&(at, ..)| at).max().unwrap_or(Fine::NEVER);
        }
        let (mut pending, mut seen) = (self.pending.clone(), seen);
        pending.sort_unstable();
        let ends = |&(_, level, driver): &(Fine, bool, NodeIndex)| {
            note(&mut seen, level, driver);
            seen == 0
        };
        pending.iter().copied().find(ends).map_or(Fine::NEVER, |(at, ..)| at)
    }
}

fn note(seen: &mut Drivers, level: bool, driver: NodeIndex) {
    if level == DOMINANT { *seen |= 1 << driver } else { *seen &= !(1 << driver) }
}

impl Arrivals {
    /// `now`: what arrived before may be taken in. `seen`: the dominant drivers that have arrived at the node.
    pub(crate) fn push(&mut self, arrival: Arrival, now: Fine, seen: &mut Drivers) {
        let Arrival { at, node, change: Change::Driver(level, driver) } = arrival else {
            return self.push_glitch(arrival);
        };
        if node >= self.lines.len() {
            self.lines.resize_with(node + 1, Line::default);
            self.turns.resize(node + 1);
        }
        let line = &mut self.lines[node];
        if now != Fine(0) {
            line.take_in(Fine(now.0 - 1), seen);
        }
        line.pending.push((at, level, driver));
        line.first = Some(line.first.map_or(at, |first| first.min(at)));
        self.last = Some(self.last.map_or(at, |last| last.max(at)));
        match level == DOMINANT {
            true if *seen == 0 => self.turns.set(node, self.turns.at[node].min(at)),
            true if self.turns.at[node] == Fine::NEVER => {}
            true => self.turns.set(node, line.turn(*seen)),
            false => {
                line.ending |= 1 << driver;
                if *seen != 0 && *seen & !line.ending == 0 {
                    self.turns.set(node, line.turn(*seen));
                }
            }
        }
    }

    /// A disturbance begins or ends.
    pub(crate) fn push_glitch(&mut self, arrival: Arrival) {
        self.glitches.push(Reverse(arrival));
    }

    /// Takes back that a driver goes to a level; `false` when that is not under way.
    pub(crate) fn withdraw(&mut self, arrival: Arrival, seen: Drivers) -> bool {
        let Arrival { at, node, change: Change::Driver(level, driver) } = arrival else { return false };
        let Some(line) = self.lines.get_mut(node) else { return false };
        let Some(index) = line.pending.iter().rposition(|other| *other == (at, level, driver)) else {
            return false;
        };
        line.pending.swap_remove(index);
        line.survey();
        self.turns.set(node, line.turn(seen));
        true
    }

    /// When something happens next, and what; [`Fine::NEVER`]: nothing.
    pub(crate) fn next(&self) -> (Fine, Next) {
        let (turn, node) = self.turns.first;
        let last = self.last.unwrap_or(Fine::NEVER);
        let glitch = self.glitches.peek().map_or(Fine::NEVER, |Reverse(arrival)| arrival.at);
        if turn <= last.min(glitch) {
            (turn, Next::Turn(node))
        } else if glitch <= last {
            (glitch, Next::Glitch)
        } else {
            (last, Next::Last)
        }
    }

    /// Takes in what has arrived at `node` at `until`.
    pub(crate) fn take_in(&mut self, node: NodeIndex, until: Fine, seen: &mut Drivers) {
        if let Some(line) = self.lines.get_mut(node) {
            line.take_in(until, seen);
            self.turns.set(node, line.turn(*seen));
        }
    }

    /// Nodes to which something is under way.
    pub(crate) fn awaiting(&self) -> Vec<NodeIndex> {
        (0..self.lines.len()).filter(|&node| !self.lines[node].pending.is_empty()).collect()
    }

    /// All level changes have arrived.
    pub(crate) fn end(&mut self) {
        self.last = None;
    }

    pub(crate) fn take_glitch(&mut self) -> Option<Arrival> {
        self.glitches.pop().map(|Reverse(arrival)| arrival)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.last.is_none() && self.glitches.is_empty()
    }

    pub(crate) fn into_iter(self) -> impl Iterator<Item = Arrival> {
        let lines = self.lines.into_iter().enumerate().flat_map(|(node, line)| {
            let arrival =
                move |(at, level, driver)| Arrival { at, node, change: Change::Driver(level, driver) };
            line.pending.into_iter().map(arrival)
        });
        lines.chain(self.glitches.into_iter().map(|Reverse(arrival)| arrival))
    }
}

#[cfg(test)]
mod tests;
