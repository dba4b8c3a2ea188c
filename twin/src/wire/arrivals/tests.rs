//! Random drivers, compared with a queue of every single level change.

use proptest::prelude::*;

use super::{Arrival, Arrivals, Change, Next};
use crate::wire::controller::NodeIndex;
use crate::wire::fine::Fine;
use crate::wire::mac::{DOMINANT, RECESSIVE};
use crate::wire::node::Drivers;

/// Nodes that drive and are driven.
const NODES: usize = 5;

/// A node's line becomes dominant (`true`) or recessive: instant, node, level.
type Turn = (Fine, NodeIndex, bool);

/// Delay from each driver to each node, at least one unit.
type Paths = [[u64; NODES]; NODES];

/// Script of a network: delay after the last change of any driver, and the driver that changes its level.
type Script = Vec<(u64, NodeIndex)>;

/// All level changes as they arrive: instant, node, level, driver.
type Queue = Vec<(Fine, NodeIndex, bool, NodeIndex)>;

/// State under test: the arrivals, the drivers that each node sees, and the reported turns.
#[derive(Default)]
struct Flown {
    arrivals: Arrivals,
    seen: [Drivers; NODES],
    turns: Vec<Turn>,
}

impl Flown {
    fn take_in(&mut self, node: NodeIndex, at: Fine) {
        let was_dominant = self.seen[node] != 0;
        self.arrivals.take_in(node, at, &mut self.seen[node]);
        let is_dominant = self.seen[node] != 0;
        assert_ne!(was_dominant, is_dominant, "a turn that is none, at {at:?}, node {node}");
        self.turns.push((at, node, is_dominant));
    }

    /// Processes everything that arrives before `end`.
    fn run_before(&mut self, end: Fine) {
        loop {
            let (at, what) = self.arrivals.next();
            if at >= end {
                return;
            }
            match what {
                Next::Turn(node) => self.take_in(node, at),
                Next::Last => {
                    for node in self.arrivals.awaiting() {
                        let was_dominant = self.seen[node] != 0;
                        self.arrivals.take_in(node, at, &mut self.seen[node]);
                        assert_eq!(self.seen[node] != 0, was_dominant, "a turn that was not told");
                    }
                    self.arrivals.end();
                }
                Next::Glitch => panic!("nothing disturbs here"),
            }
        }
    }

    /// Changes the level of a driver. A change back at the same instant cancels the first one.
    fn change(&mut self, now: Fine, level: bool, driver: NodeIndex, is_back: bool, paths: &Paths) {
        for (node, path) in paths[driver].iter().enumerate() {
            let at = Fine(now.0 + path);
            let arrival = |level| Arrival { at, node, change: Change::Driver(level, driver) };
            if is_back {
                assert!(self.arrivals.withdraw(arrival(!level), self.seen[node]), "under way to {node}");
            } else {
                self.arrivals.push(arrival(level), now, &mut self.seen[node]);
            }
        }
    }
}

/// Returns when the line of each node changes, change by change. At equal instants dominant changes come first.
fn turns_of(queue: &mut Queue) -> Vec<Turn> {
    queue.sort_unstable_by_key(|&(at, node, level, driver)| (at, node, level != DOMINANT, driver));
    let mut seen = [[false; NODES]; NODES];
    let mut turns = vec![];
    for &(at, node, level, driver) in &*queue {
        let was_dominant = seen[node].contains(&true);
        seen[node][driver] = level == DOMINANT;
        let is_dominant = seen[node].contains(&true);
        if was_dominant != is_dominant {
            turns.push((at, node, is_dominant));
        }
    }
    turns
}

fn scripts() -> impl Strategy<Value = (Paths, Script)> {
    // Short gaps, so that changes overtake each other, coincide, and are cancelled.
    let gap = prop_oneof![3 => Just(0), 3 => 1..6_u64, 1 => 6..60_u64];
    let paths = prop::array::uniform(prop::array::uniform(1..20_u64));
    (paths, prop::collection::vec((gap, 0..NODES), 0..60))
}

proptest! {
    #[test]
    fn lines_turn_as_with_every_change_on_its_own((paths, script) in scripts()) {
        let (mut flown, mut queue, mut now) = (Flown::default(), Queue::new(), Fine(0));
        let (mut levels, mut changed_at) = ([RECESSIVE; NODES], [None; NODES]);
        for (gap, driver) in script {
            now = Fine(now.0 + gap);
            flown.run_before(now);
            levels[driver] = !levels[driver];
            let (level, is_back) = (levels[driver], changed_at[driver] == Some(now));
            flown.change(now, level, driver, is_back, &paths);
            changed_at[driver] = if is_back { None } else { Some(now) };
            for (node, path) in paths[driver].iter().enumerate() {
                let at = Fine(now.0 + path);
                if is_back {
                    queue.retain(|change| *change != (at, node, !level, driver));
                } else {
                    queue.push((at, node, level, driver));
                }
            }
        }
        flown.run_before(Fine::NEVER);
        flown.turns.sort_unstable();
        prop_assert_eq!(flown.turns, turns_of(&mut queue));
        let driving = (0..NODES).filter(|driver| levels[*driver] == DOMINANT);
        let driving = driving.fold(0, |driving: Drivers, driver| driving | 1 << driver);
        prop_assert_eq!(flown.seen, [driving; NODES]);
        prop_assert!(flown.arrivals.is_empty());
    }
}
