//! What the applications of a world note.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

use can_wire::time::Time;
use ecss_can::types::{Bus, Instant, NodeId};
use host_worlds::NodeKey;
use mission::COMMAND_PERIOD;

/// Commands of one life of a master: their values begin at a multiple of it.
const LIFE: u32 = 1 << 16;

/// A command that a slave executed.
#[derive(Clone, Copy, Debug)]
pub struct Execution {
    /// When.
    pub at: Time,
    /// By whom.
    pub node: NodeId,
    /// Rises with every command to this slave, also over resets of a master. No two masters give the same one.
    pub value: u32,
}

/// What the applications noted so far.
#[derive(Default)]
pub struct Notes {
    /// In the order of time.
    pub executions: RefCell<Vec<Execution>>,
    /// Whether the error of a slave is there.
    pub errors: RefCell<BTreeMap<NodeId, bool>>,
    /// Where one of two masters became active, the next one first.
    pub takeovers: RefCell<VecDeque<Bus>>,
    /// Those of two masters that are active.
    active: RefCell<BTreeSet<NodeKey>>,
    /// Power-ons of the masters.
    lives: RefCell<Vec<NodeKey>>,
}

impl Notes {
    /// Who made a command, and when by its clock; `None` in another life of it.
    pub fn made(&self, value: u32) -> Option<(NodeKey, Instant)> {
        let lives = self.lives.borrow();
        let index = life(value).checked_sub(1)? as usize;
        let key = *lives.get(index)?;
        let is_this_life = !lives[index + 1..].contains(&key);
        is_this_life.then(|| (key, Instant::ZERO + COMMAND_PERIOD.times(value % LIFE)))
    }

    /// One of two masters becomes active, or ceases to be.
    pub fn set_active(&self, key: NodeKey, is_active: bool) {
        let mut active = self.active.borrow_mut();
        if is_active {
            active.insert(key)
        } else {
            active.remove(&key)
        };
    }

    /// Whether this one of two masters is active.
    pub fn is_active(&self, key: NodeKey) -> bool {
        self.active.borrow().contains(&key)
    }

    /// A master begins another life. First value of its commands.
    pub fn begin(&self, key: NodeKey) -> u32 {
        self.set_active(key, false);
        let mut lives = self.lives.borrow_mut();
        lives.push(key);
        lives.len() as u32 * LIFE
    }
}

/// Number of the life of a master that made a command, from 1.
pub fn life(value: u32) -> u32 {
    value / LIFE
}
