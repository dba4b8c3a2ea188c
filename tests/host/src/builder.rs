//! What a world is made of.

use can_wire::time::Time;
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

use crate::world::World;

/// Nodes before their world begins. Unless told otherwise clocks are exact, all nodes get power at time zero, and the
/// application of the master is silent.
#[derive(Clone, Debug)]
pub struct Builder {
    profile: Profile,
    /// Node, drift in ppm, power-on.
    boards: Vec<(NodeId, i32, Time)>,
    traffic: bool,
}

impl Builder {
    pub(crate) fn new(profile: Profile, slaves: u8) -> Self {
        let ids = (1..=slaves + 1).map(|raw| NodeId::new(raw).expect("at most 126 slaves"));
        Builder { profile, boards: ids.map(|id| (id, 0, Time::ZERO)).collect(), traffic: false }
    }

    /// The clock of a node is fast by so many millionths.
    #[must_use]
    pub fn drift(mut self, node: NodeId, ppm: i32) -> Self {
        self.board(node).1 = ppm;
        self
    }

    /// A node gets power then.
    #[must_use]
    pub fn powered_at(mut self, node: NodeId, at: Time) -> Self {
        self.board(node).2 = at;
        self
    }

    /// The application of the master commands and asks every slave once per period of the mission.
    #[must_use]
    pub fn traffic(mut self) -> Self {
        self.traffic = true;
        self
    }

    /// Drifts within 100 ppm and power-on within the first 50 ms, drawn from a seed.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        for (_, ppm, power_on) in &mut self.boards {
            *ppm = random.i32(-100..=100);
            *power_on = Time::from_us(random.u64(0..50_000));
        }
        self
    }

    /// The world at time zero.
    pub fn build(self) -> World {
        World::new(self.profile, self.boards, self.traffic)
    }

    fn board(&mut self, node: NodeId) -> &mut (NodeId, i32, Time) {
        self.boards.iter_mut().find(|(id, ..)| *id == node).expect("a node of this world")
    }
}
