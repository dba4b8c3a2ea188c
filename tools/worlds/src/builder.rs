//! Builder of a world.

use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;
use ecss_can::node::{Master, Slave, SpacecraftDevice};
use ecss_can::redundancy::MasterBoards;
use ecss_can::types::{Frame, NodeId};

use crate::board::MockBoard;
use crate::key::NodeKey;
use crate::member::{Events, Handle, Member};
use crate::port::Missed;
use crate::unit::{Planned, firmware};
use crate::world::World;

/// Multiplier that makes different patterns of different numbers: odd, 2^32 divided by the golden ratio.
const SCATTER: u32 = 0x9E37_79B1;

impl World {
    /// A world without nodes yet.
    pub fn builder() -> Builder {
        Builder::default()
    }
}

/// Nodes of a world before its start. By default clocks are exact and all nodes get power at time zero.
pub struct Builder {
    nodes: Vec<Planned>,
    timing: BitTiming,
}

impl Default for Builder {
    fn default() -> Self {
        Builder { nodes: Vec::new(), timing: BitTiming::MEGABIT }
    }
}

impl Builder {
    /// Adds a master. At each power-on and each reset `node` makes it, and `application` runs with it.
    ///
    /// # Panics
    /// When there is one already.
    #[must_use]
    pub fn master<D: SpacecraftDevice, B: MasterBoards, A: Future<Output = ()> + 'static>(
        self,
        node: impl Fn(MockBoard) -> Master<D, B> + 'static,
        application: impl Fn(Handle<Master<D, B>>, Events<Master<D, B>>) -> A + 'static,
    ) -> Self {
        self.board(NodeKey::MASTER, node, application)
    }

    /// Adds a slave. At each power-on and each reset `node` makes it, and `application` runs with it.
    ///
    /// # Panics
    /// When there is a node with this Node-ID, or it is the master's.
    #[must_use]
    pub fn slave<D: SpacecraftDevice, A: Future<Output = ()> + 'static>(
        self,
        id: NodeId,
        node: impl Fn(MockBoard) -> Slave<D> + 'static,
        application: impl Fn(Handle<Slave<D>>, Events<Slave<D>>) -> A + 'static,
    ) -> Self {
        assert_ne!(id, NodeId::MASTER, "this Node-ID is the master's: use 2 to 127");
        self.board(id, node, application)
    }

    /// Adds another board: a minimal slave (ECSS 9) by its Node-ID, the second one of two master boards, [`NodeKey::SECOND_MASTER`], or a
    /// second slave board with a Node-ID, [`NodeKey::double`]. The second master is at the other end of the cable, all slaves are
    /// between the two; the second slave board is a metre further on than the first one.
    ///
    /// # Panics
    /// When there is one.
    #[must_use]
    pub fn board<N: Member, A: Future<Output = ()> + 'static>(
        mut self,
        key: impl Into<NodeKey>,
        node: impl Fn(MockBoard) -> N + 'static,
        application: impl Fn(Handle<N>, Events<N>) -> A + 'static,
    ) -> Self {
        let key = key.into();
        assert!(self.nodes.iter().all(|other| other.key != key), "two nodes with {key:?}");
        let firmware = firmware(node, application);
        self.nodes.push(Planned {
            key,
            firmware,
            drift_ppm: 0,
            has_one_controller: false,
            power_on: Time::ZERO,
            late_heartbeats: key.number().wrapping_mul(SCATTER),
            missed: Missed::default(),
        });
        self
    }

    /// Makes the clock of a node fast by `ppm` parts per million.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn drift(mut self, node: impl Into<NodeKey>, ppm: i32) -> Self {
        self.planned(node.into()).drift_ppm = ppm;
        self
    }

    /// Sets the pattern of late heartbeats of a board, in [`MockBoard::hardware`]. By default each board has a
    /// different one.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn late_heartbeats(mut self, node: impl Into<NodeKey>, pattern: u32) -> Self {
        self.planned(node.into()).late_heartbeats = pattern;
        self
    }

    /// Makes the controllers of a node miss the frames on both buses for which `is_missed` returns true at their end.
    /// The controllers acknowledge them, and the node does not receive them.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn misses(mut self, node: impl Into<NodeKey>, is_missed: impl Fn(&Frame) -> bool + 'static) -> Self {
        self.planned(node.into()).missed = Missed::those(is_missed);
        self
    }

    /// Gives a node one controller and a transceiver switch (ECSS Figure A-6). It has selective access.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn one_controller(mut self, node: impl Into<NodeKey>) -> Self {
        self.planned(node.into()).has_one_controller = true;
        self
    }

    /// Sets the instant at which a node gets power.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn powered_at(mut self, node: impl Into<NodeKey>, at: Time) -> Self {
        self.planned(node.into()).power_on = at;
        self
    }

    /// Gives every node a drift within 100 ppm and power within the first 50 ms, drawn from a seed.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        for node in &mut self.nodes {
            node.drift_ppm = random.i32(-100..=100);
            node.power_on = Time::from_us(random.u64(0..50_000));
        }
        self
    }

    /// Sets the bit rate of both buses in place of 1 Mbit/s. The profile of the nodes has to have the same.
    ///
    /// # Panics
    /// When it is zero.
    #[must_use]
    pub fn kbit(mut self, kbit_per_s: u32) -> Self {
        self.timing = BitTiming::kbit(kbit_per_s);
        self
    }

    /// Makes the world at time zero.
    pub fn build(self) -> World {
        World::new(self.nodes, self.timing)
    }

    fn planned(&mut self, key: NodeKey) -> &mut Planned {
        let found = self.nodes.iter_mut().find(|planned| planned.key == key);
        found.unwrap_or_else(|| panic!("{key:?} is no node of this world"))
    }
}

#[cfg(test)]
mod tests {
    use can_twin::wire::time::TICKS_PER_US;
    use can_twin::wire::timing::Quantum;
    use ecss_can::link::bit_timing::{BitTiming as Settings, Hertz, Limits, Range};
    use ecss_can::profile::Profile;

    use super::*;

    /// The bit timing of a world is that of bxCAN on the pyboard, whose APB1 has 42 MHz, with the default profile.
    #[test]
    fn a_world_has_the_bit_timing_of_the_boards() {
        let bxcan = Limits {
            prescaler: Range::new(1, 1024),
            segment1: Range::new(1, 16),
            segment2: Range::new(1, 8),
            jump_width: 4,
        };
        let set = Settings::new(&bxcan, Hertz(42_000_000), &Profile::DEFAULT.network).unwrap();
        let quantum = Quantum::new(TICKS_PER_US * u64::from(set.prescaler()), 42);
        let timing = BitTiming::new(quantum, set.segment1(), set.segment2(), set.jump_width());
        assert_eq!(World::builder().timing, timing);
    }
}
