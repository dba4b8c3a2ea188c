//! Records of the applications of a world.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

use can_twin::wire::time::Time;
use ecss_can::types::{Bus, Instant, NodeId};
use ecss_can_worlds::NodeKey;
use mission::COMMAND_PERIOD;

/// Number of command values of one life of a master, which begin at a multiple of it.
const LIFE: u32 = 1 << 16;

/// A command that a slave executed.
#[derive(Clone, Copy, Debug)]
pub struct Execution {
    /// Instant of the execution.
    pub at: Time,
    /// Slave that executed it.
    pub node: NodeId,
    /// Value of the command. It rises with every command to this slave, also over resets of a master, and is different
    /// for two masters.
    pub value: u32,
}

/// Records of the applications so far.
#[derive(Default)]
pub struct Notes {
    /// Executed commands in chronological order.
    pub executions: RefCell<Vec<Execution>>,
    /// Whether the error of each slave is active.
    pub errors: RefCell<BTreeMap<NodeId, bool>>,
    /// Buses on which one of two masters became active, the next one first.
    pub takeovers: RefCell<VecDeque<Bus>>,
    /// Masters that are active, of two.
    active: RefCell<BTreeSet<NodeKey>>,
    /// Master of each power-on, in order.
    lives: RefCell<Vec<NodeKey>>,
}

impl Notes {
    /// Returns the master that made a command, and when by its clock; `None` if it was in another life.
    pub fn made(&self, value: u32) -> Option<(NodeKey, Instant)> {
        let lives = self.lives.borrow();
        let index = life(value).checked_sub(1)? as usize;
        let key = *lives.get(index)?;
        let is_this_life = !lives[index + 1..].contains(&key);
        is_this_life.then(|| (key, Instant::ZERO + COMMAND_PERIOD.times(value % LIFE)))
    }

    /// Records that one of two masters becomes active or inactive.
    pub fn set_active(&self, key: NodeKey, is_active: bool) {
        let mut active = self.active.borrow_mut();
        if is_active {
            active.insert(key)
        } else {
            active.remove(&key)
        };
    }

    /// Returns whether this one of two masters is active.
    pub fn is_active(&self, key: NodeKey) -> bool {
        self.active.borrow().contains(&key)
    }

    /// Begins another life of a master. Returns the first value of its commands.
    pub fn begin(&self, key: NodeKey) -> u32 {
        self.set_active(key, false);
        let mut lives = self.lives.borrow_mut();
        lives.push(key);
        lives.len() as u32 * LIFE
    }
}

/// Returns the number of the master's life that made a command, from 1.
pub fn life(value: u32) -> u32 {
    value / LIFE
}
