//! Changes that propagate to the nodes of a segment: level changes of drivers, and disturbances.
//!
//! If many drivers change at almost the same time, a node sees the first that becomes dominant and the last that
//! becomes recessive. Only these two are events; the others are processed with the next event.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::wire::calendar::Earliest;
use crate::wire::controller::NodeIndex;
use crate::wire::fault::Effect;
use crate::wire::fine::Fine;
use crate::wire::mac::DOMINANT;
use crate::wire::node::Drivers;

/// A change that reaches a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::wire) struct Arrival {
    pub(in crate::wire) at: Fine,
    pub(in crate::wire) node: NodeIndex,
    pub(in crate::wire) change: Change,
}

/// Change at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::wire) enum Change {
    /// A driver changes to this level.
    Driver(bool, NodeIndex),
    /// A disturbance begins.
    GlitchBegins(Effect),
    /// A disturbance ends.
    GlitchEnds(Effect),
}

/// Changes that propagate to the nodes of a segment.
#[derive(Clone, Debug, Default)]
pub(in crate::wire) struct Arrivals {
    /// Changes that propagate to each node.
    lines: Vec<PendingChanges>,
    /// Instants at which the line of each node becomes dominant or recessive.
    turns: Earliest,
    glitches: BinaryHeap<Reverse<Arrival>>,
    /// Instant at which the last level change arrives.
    last: Option<Fine>,
}

/// Level changes of drivers that propagate to one node.
#[derive(Clone, Debug, Default)]
struct PendingChanges {
    /// Instant, level and driver of each change. At equal instants dominant changes come first, so that there is no
    /// pulse if one driver takes over from another.
    pending: Vec<(Fine, bool, NodeIndex)>,
    /// Instant of the earliest change.
    first: Option<Fine>,
    /// Drivers that become recessive.
    ending: Drivers,
}

/// The next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wire) enum Next {
    /// The line of a node becomes dominant or recessive.
    Turn(NodeIndex),
    /// A disturbance begins or ends.
    Glitch,
    /// The last level change arrives.
    Last,
}

impl PendingChanges {
    /// Processes the changes that have arrived at `until`.
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

    /// Returns the instant at which the line becomes dominant or recessive.
    fn turn(&self, seen: Drivers) -> Fine {
        let mut begins = self.pending.iter().filter(|(_, level, _)| *level == DOMINANT).peekable();
        if seen == 0 {
            return begins.map(|&(at, ..)| at).min().unwrap_or(Fine::NEVER);
        }
        if seen & !self.ending != 0 {
            return Fine::NEVER;
        }
        if begins.peek().is_none() {
            // The line becomes recessive when all dominant drivers have ended.
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
    /// Adds a level change. `now`: earlier changes may be processed. `seen`: the dominant drivers that have arrived at
    /// the node.
    pub(in crate::wire) fn push(&mut self, arrival: Arrival, now: Fine, seen: &mut Drivers) {
        let Arrival { at, node, change: Change::Driver(level, driver) } = arrival else {
            return self.push_glitch(arrival);
        };
        if node >= self.lines.len() {
            self.lines.resize_with(node + 1, PendingChanges::default);
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

    /// Adds the beginning or end of a disturbance.
    pub(in crate::wire) fn push_glitch(&mut self, arrival: Arrival) {
        self.glitches.push(Reverse(arrival));
    }

    /// Removes a level change of a driver. Returns `false` if it is not pending.
    pub(in crate::wire) fn withdraw(&mut self, arrival: Arrival, seen: Drivers) -> bool {
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

    /// Returns the next event and its instant; [`Fine::NEVER`]: none.
    pub(in crate::wire) fn next(&self) -> (Fine, Next) {
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

    /// Processes the changes that have arrived at `node` at `until`.
    pub(in crate::wire) fn take_in(&mut self, node: NodeIndex, until: Fine, seen: &mut Drivers) {
        if let Some(line) = self.lines.get_mut(node) {
            line.take_in(until, seen);
            self.turns.set(node, line.turn(*seen));
        }
    }

    /// Returns the nodes with pending changes.
    pub(in crate::wire) fn awaiting(&self) -> Vec<NodeIndex> {
        (0..self.lines.len()).filter(|&node| !self.lines[node].pending.is_empty()).collect()
    }

    /// Ends the propagation: all level changes have arrived.
    pub(in crate::wire) fn end(&mut self) {
        self.last = None;
    }

    pub(in crate::wire) fn take_glitch(&mut self) -> Option<Arrival> {
        self.glitches.pop().map(|Reverse(arrival)| arrival)
    }

    pub(in crate::wire) fn is_empty(&self) -> bool {
        self.last.is_none() && self.glitches.is_empty()
    }

    pub(in crate::wire) fn into_iter(self) -> impl Iterator<Item = Arrival> {
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
