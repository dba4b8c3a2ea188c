//! The slaves as the master hears them: states, who is lost, who is silent on the active bus.

use crate::heartbeat::Consumer;
use crate::nmt::{NmtState, NodeId, Target};
use crate::time::{Duration, Instant};

/// Node-IDs 0..=127; those of no slave stay empty.
const PLACES: usize = 128;

/// Every slave heard since power-on.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Peers {
    places: [Option<Peer>; PLACES],
    /// Not to be started unasked, heard already or not: the application stopped them. One bit per Node-ID.
    held: u128,
    /// No peer is overdue before. Later heartbeats only move the truth further away.
    check: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Peer {
    state: NmtState,
    heartbeat: Consumer,
    /// Silent on the active bus from then on.
    silent_at: Instant,
}

/// What a heartbeat told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heard {
    /// The first word of this slave, or another state than before.
    pub changed: bool,
    /// It had been lost.
    pub returned: bool,
    /// It waits in Pre-operational and nobody wants it to: start it (ECSS 8.3.3f).
    pub start: bool,
}

impl Default for Peers {
    fn default() -> Self {
        Self::new()
    }
}

impl Peers {
    /// Nobody heard yet.
    pub const fn new() -> Self {
        Peers { places: [None; PLACES], held: 0, check: None }
    }

    /// A heartbeat or boot-up message of `node`, on the active bus or not. `consumer` is its consumer time,
    /// `settling` what a slave heard on the other bus may take to come to the active one.
    pub fn on_heartbeat(
        &mut self,
        node: NodeId,
        state: NmtState,
        active: bool,
        at: Instant,
        (consumer, settling): (Duration, Duration),
    ) -> Heard {
        let Some(place) = self.places.get_mut(usize::from(node.get())) else { return Heard::default() };
        let known = place.is_some();
        let peer = place.get_or_insert(Peer {
            state,
            heartbeat: Consumer::Unarmed,
            silent_at: at + settling.max(consumer),
        });
        if active {
            peer.silent_at = at + consumer;
        }
        let returned = peer.heartbeat.on_heartbeat(at);
        let changed = !known || peer.state != state;
        peer.state = state;
        let waiting = matches!(state, NmtState::PreOperational | NmtState::Initialising);
        let next = peer.silent_at.min(at + consumer);
        self.check = Some(self.check.map_or(next, |check| check.min(next)));
        let held = self.held & node_bit(node) != 0;
        Heard { changed, returned, start: active && waiting && !held }
    }

    /// The active bus changed: everybody gets `settling` to be heard there.
    pub fn on_switch(&mut self, now: Instant, settling: Duration) {
        for peer in self.places.iter_mut().flatten() {
            peer.silent_at = now + settling;
        }
        self.check = Some(now);
    }

    /// The application wants these slaves to run, or not to be started unasked; those too that were not heard yet.
    pub fn hold(&mut self, target: Target, held: bool) {
        let nodes = match target {
            Target::All => u128::MAX,
            Target::Node(node) => node_bit(node),
        };
        self.held = if held { self.held | nodes } else { self.held & !nodes };
    }

    /// Whether the application wants this slave not to be started.
    pub fn is_held(&self, node: NodeId) -> bool {
        self.held & node_bit(node) != 0
    }

    /// Look at everybody again at `now`: the circumstances changed.
    pub fn recheck(&mut self, now: Instant) {
        self.check = Some(now);
    }

    /// Whether [`Peers::next_lost`] and [`Peers::silent`] may have news.
    pub fn is_due(&self, now: Instant) -> bool {
        self.check.is_some_and(|check| check <= now)
    }

    /// The next slave whose heartbeat is overdue on both buses, each once.
    pub fn next_lost(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        self.iter_mut().find_map(|(node, peer)| peer.heartbeat.poll(now, consumer).map(|_| node))
    }

    /// How many are silent on the active bus, and how many there are.
    pub fn silent(&self, now: Instant) -> (u8, u8) {
        let count = |silent: u8, peer: &Peer| silent.saturating_add(u8::from(peer.silent_at <= now));
        let all = self.places.iter().flatten();
        let total = all.clone().fold(0_u8, |total, _| total.saturating_add(1));
        (all.fold(0, count), total)
    }

    /// Everything due at `now` was asked: look for the next instant.
    pub fn checked(&mut self, now: Instant, consumer: Duration) {
        let silences = self.places.iter().flatten().map(|peer| peer.silent_at).filter(|at| *at > now);
        let losses = self.places.iter().flatten().filter_map(|peer| peer.heartbeat.deadline(consumer));
        self.check = silences.chain(losses).min();
    }

    /// When somebody may be overdue next.
    pub fn deadline(&self) -> Option<Instant> {
        self.check
    }

    /// Last state heard of a slave; `None` when it was never heard or is lost.
    pub fn state(&self, node: NodeId) -> Option<NmtState> {
        let peer = self.places.get(usize::from(node.get()))?.as_ref()?;
        (!peer.heartbeat.is_missed()).then_some(peer.state)
    }

    fn iter_mut(&mut self) -> impl Iterator<Item = (NodeId, &mut Peer)> {
        self.places
            .iter_mut()
            .zip(0_u8..)
            .filter_map(|(place, raw)| Some((NodeId::new(raw)?, place.as_mut()?)))
    }
}

fn node_bit(node: NodeId) -> u128 {
    1 << (node.get() & 0x7F)
}
