//! Nodes that the master hears: their states, and which of them count, are lost or silent.

use super::Parameters;
use crate::heartbeat::{Consumer, ConsumerTimes, monitored};
use crate::nmt::Target;
use crate::types::{Canonical, Duration, Instant, NmtState, NodeId};

mod heard;
mod period;

/// Node-IDs 0..=127; those of no slave stay empty.
pub(super) const PLACES: usize = 128;
/// Consumer times without a heartbeat after which a node is forgotten that has to answer first, or again.
const MEMORY: u32 = 10;
/// Questions to a new node. One may be lost, and a slow server needs some seconds after its boot-up message.
const QUESTIONS: u8 = 3;

/// A set of nodes: bit n stands for Node-ID n.
pub(super) type NodeSet = u128;

/// Nodes heard since power-on. Node-IDs are below `N`.
///
/// A node counts for the decisions of the master if 1F81h assigns it, or if its SDO server answered once. Any other node
/// is a *foreign node*. The master follows its state, but neither its heartbeats nor its silence decide anything. After
/// ten consumer times of silence the master forgets it.
///
/// A node that counts goes on to count after its boot-up message, because a reset must not hide that its bus is broken.
/// It has to answer again. Until then ten consumer times of silence on both buses make the master forget it as well.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = Parameters)]
pub struct Peers<const N: usize = PLACES> {
    #[canonical(each = |nth| self.times_of(nth, context))]
    places: [Option<Peer>; N],
    /// Consumer times of their own, milliseconds; zero for those that share the common one.
    times: [u16; N],
    /// Heartbeat periods of nodes that 1F81h does not assign, milliseconds: the last gap between two heartbeats,
    /// where it was longer than the common consumer time. Else zero.
    periods: [u16; N],
    /// Assigned by 1F81h.
    assigned: NodeSet,
    /// Answered once.
    answered: NodeSet,
    /// Slaves of the master that was active before, which did not answer this one yet. They count.
    adopted: NodeSet,
    /// Answered or adopted before their last boot-up message, and no answer since.
    rebooted: NodeSet,
    /// Nodes whose device type has to be read, once they are heard on the active bus in a state that allows SDO.
    unasked: NodeSet,
    /// Those of them that were heard so.
    ready: NodeSet,
    /// Assigned and never heard.
    unheard: NodeSet,
    /// Not to be started unasked, heard or not: the application stopped them.
    held: NodeSet,
    /// No peer has anything due before. Later heartbeats only move the truth further away.
    #[canonical(due)]
    check: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = PeerTimes)]
struct Peer {
    state: NmtState,
    /// Questions without an answer since the node was first heard, or since its last boot-up message.
    unanswered: u8,
    #[canonical(within = context.heartbeat)]
    heartbeat: Consumer,
    /// Silent on the active bus from then on.
    // How long ago counts only together with the first heartbeat on the other bus.
    #[canonical(age = if self.first_there < Instant::NEVER { context.hold } else { Duration::ZERO })]
    silent_at: Instant,
    /// First and last heartbeat on the other bus since the last one on the active bus, never and zero without.
    #[canonical(age = context.hold)]
    first_there: Instant,
    #[canonical(age = context.hold)]
    last_there: Instant,
}

/// Times for which what a [`Peer`] notes has an effect.
struct PeerTimes {
    heartbeat: ConsumerTimes,
    /// [`Parameters::hold_time`].
    hold: Duration,
}

impl Peer {
    /// Silent on the active bus and heard on the other one for the hold time, from then on.
    fn elsewhere_at(&self, parameters: &Parameters) -> Instant {
        self.silent_at.max(self.first_there) + parameters.hold_time()
    }

    fn is_elsewhere(&self, now: Instant, parameters: &Parameters) -> bool {
        self.elsewhere_at(parameters) <= now && self.last_there + parameters.hold_time() > now
    }

    /// Returns when the node is forgotten if it may be.
    fn forgotten_at(&self, consumer: Duration) -> Option<Instant> {
        match self.heartbeat {
            Consumer::Missed { last } => Some(last + consumer.times(MEMORY)),
            Consumer::Unarmed | Consumer::Armed { .. } => None,
        }
    }
}

/// Meaning of a heartbeat for the master.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PeerHeartbeat {
    /// `true`: first heartbeat of this node, or one that reports a new state.
    pub changed: bool,
    /// `true`: the node was lost before.
    pub returned: bool,
    /// `true`: the node is not Operational and not held. Start it (ECSS 8.3.3f).
    pub start: bool,
}

impl<const N: usize> Default for Peers<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Peers<N> {
    /// Makes a record without nodes.
    #[inline(never)] // made in their place
    pub const fn new() -> Self {
        Peers {
            places: [None; N],
            times: [0; N],
            periods: [0; N],
            assigned: 0,
            answered: 0,
            adopted: 0,
            rebooted: 0,
            unasked: 0,
            ready: 0,
            unheard: 0,
            held: 0,
            check: None,
        }
    }

    /// Takes an entry of 1F81h. A slave that is removed is forgotten. It counts again when it answers.
    pub fn assign(&mut self, node: NodeId, is_slave: bool) {
        let bit = node_bit(node);
        let was_slave = self.assigned & bit != 0;
        if let Some(period) = self.periods.get_mut(usize::from(node.get())) {
            *period = 0;
        }
        if self.place(node).is_some() {
            self.recheck(Instant::ZERO);
        }
        if is_slave {
            self.assigned |= bit;
            self.unheard |= if self.place(node).is_none() { bit } else { 0 };
        } else if was_slave {
            self.assigned &= !bit;
            self.forget(node);
        }
    }

    /// Sets the consumer times of the entries of 1016h that are in use. Other nodes have the common one.
    pub fn set_times(&mut self, entries: &[u32]) {
        self.times = [0; N];
        for entry in entries {
            if let Some(node) = monitored(*entry)
                && let Some(time) = self.times.get_mut(usize::from(node.get()))
            {
                *time = *entry as u16;
            }
        }
    }

    /// Returns whether `node` counts for the master's decisions.
    pub fn counts(&self, node: NodeId) -> bool {
        self.counted() & node_bit(node) != 0
    }

    /// Takes a heartbeat or boot-up message of `node`. `active`: it came on the active bus.
    pub fn on_heartbeat(
        &mut self,
        node: NodeId,
        state: NmtState,
        active: bool,
        at: Instant,
        parameters: &Parameters,
    ) -> PeerHeartbeat {
        let (bit, consumer) = (node_bit(node), parameters.consumer);
        self.observe(node, at, consumer);
        let (own, counts) = (self.time(node, consumer), self.counted() & bit != 0);
        let Some(place) = self.places.get_mut(usize::from(node.get())) else {
            return PeerHeartbeat::default();
        };
        let known = place.is_some();
        let peer = place.get_or_insert_with(|| Peer {
            state,
            unanswered: 0,
            heartbeat: Consumer::Unarmed,
            // Time in which a slave heard on the other bus may come to the active one.
            silent_at: at + parameters.settling_time().max(consumer),
            first_there: Instant::NEVER,
            last_there: Instant::ZERO,
        });
        let may_be_elsewhere = counts && !active;
        let was_elsewhere = may_be_elsewhere && peer.is_elsewhere(at, parameters);
        if active {
            peer.silent_at = at + consumer;
            (peer.first_there, peer.last_there) = (Instant::NEVER, Instant::ZERO);
        } else {
            (peer.first_there, peer.last_there) = (peer.first_there.min(at), at);
        }
        let returned = peer.heartbeat.on_heartbeat(at);
        let changed = !known || peer.state != state;
        peer.state = state;
        let waiting = state != NmtState::Operational;
        let mut next = peer.heartbeat.deadline(own).unwrap_or(Instant::NEVER);
        // An instant before this heartbeat was checked when it was due.
        if counts && peer.silent_at > at {
            next = next.min(peer.silent_at);
        }
        if may_be_elsewhere {
            let elsewhere_at = peer.elsewhere_at(parameters);
            if elsewhere_at > at {
                next = next.min(elsewhere_at);
            } else if !was_elsewhere {
                next = at;
            }
        }
        if next < Instant::NEVER {
            self.check = Some(self.check.map_or(next, |check| check.min(next)));
        }
        self.unheard &= !bit;
        if state == NmtState::Initialising {
            peer.unanswered = 0;
            self.rebooted |= (self.answered | self.adopted) & bit;
        }
        if !known || state == NmtState::Initialising {
            self.unasked |= bit;
        }
        if active && state.allows_sdo() {
            self.ready |= self.unasked & bit;
        }
        PeerHeartbeat { changed, returned, start: active && waiting && self.held & bit == 0 }
    }

    /// Returns the next node whose device type (1000h) has to be read: one that is new, or booted up, or did not answer
    /// before. Nodes with fewer unanswered questions go first.
    pub fn take_unasked(&mut self) -> Option<NodeId> {
        let ready = self.each_of(self.ready & !self.assigned);
        let (node, _) = ready.min_by_key(|(_, peer)| peer.unanswered)?;
        self.ready &= !node_bit(node);
        self.unasked &= !node_bit(node);
        Some(node)
    }

    /// Returns whether [`Peers::take_unasked`] has a node.
    pub const fn is_any_unasked(&self) -> bool {
        self.ready & !self.assigned != 0
    }

    /// Makes a node be asked again, because the question was lost with its bus.
    pub fn ask_again(&mut self, node: NodeId) {
        self.unasked |= node_bit(node);
    }

    /// Returns whether `node` left a question without an answer, so that a late answer is one.
    pub fn is_answer_late(&self, node: NodeId) -> bool {
        self.place(node).is_some_and(|peer| peer.unanswered > 0)
    }

    /// Takes an answer of the SDO server of `node`: the node counts.
    pub fn on_answer(&mut self, node: NodeId, now: Instant) {
        let Some(Some(peer)) = self.places.get_mut(usize::from(node.get())) else { return };
        peer.unanswered = 0;
        self.answered |= node_bit(node);
        for set in [&mut self.adopted, &mut self.rebooted, &mut self.unasked, &mut self.ready] {
            *set &= !node_bit(node);
        }
        self.recheck(now);
    }

    /// Takes the timeout of the question to `node`. The node is asked again when it is next heard on the active bus, up to
    /// three times. A node that was [adopted](Peers::adopt), and is heard on the active bus, no longer counts after the
    /// last time. Returns `true` the first time if the node does not count, and when it no longer counts.
    pub fn on_no_answer(&mut self, node: NodeId, now: Instant) -> bool {
        let bit = node_bit(node);
        let Some(Some(peer)) = self.places.get_mut(usize::from(node.get())) else { return false };
        peer.unanswered = peer.unanswered.saturating_add(1);
        let mut is_news = peer.unanswered == 1;
        if peer.unanswered < QUESTIONS {
            self.unasked |= bit;
        } else if peer.silent_at > now {
            is_news |= self.adopted & bit != 0;
            self.adopted &= !bit;
            self.rebooted &= self.answered | !bit;
        }
        is_news && !self.counts(node)
    }

    /// Counts each of `slaves` that was heard as if it had answered. The master asks them anyway.
    pub fn adopt(&mut self, slaves: NodeSet) {
        let heard = self.each_of(slaves).fold(0, |heard, (node, _)| heard | node_bit(node));
        self.adopted |= heard & !self.answered;
    }

    /// Notes that the active bus changed. Every node has until `silent_at` to be heard there.
    pub fn on_switch(&mut self, now: Instant, silent_at: Instant) {
        for peer in self.places.iter_mut().flatten() {
            peer.silent_at = silent_at;
            (peer.first_there, peer.last_there) = (Instant::NEVER, Instant::ZERO);
        }
        self.ready = 0;
        self.recheck(now);
    }

    /// Holds slaves or releases them: a held slave is not started by the master itself. Slaves not heard yet are
    /// included.
    pub fn hold(&mut self, target: Target, held: bool) {
        let nodes = match target {
            Target::All => NodeSet::MAX,
            Target::Node(node) => node_bit(node),
        };
        self.held = if held { self.held | nodes } else { self.held & !nodes };
    }

    /// Returns whether the application holds this slave.
    pub fn is_held(&self, node: NodeId) -> bool {
        self.held & node_bit(node) != 0
    }

    /// Requests a check of every node at `now`, after a change of the bus, of the health or of the assignment.
    pub fn recheck(&mut self, now: Instant) {
        self.check = Some(now);
    }

    /// Returns whether a check is due.
    pub fn is_due(&self, now: Instant) -> bool {
        self.check.is_some_and(|check| check <= now)
    }

    /// Returns the next node whose heartbeat is overdue on both buses, each once.
    pub fn next_lost(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        (0..N).find_map(|nth| {
            let node = NodeId::new(nth as u8)?;
            let time = self.time(node, consumer);
            self.places.get_mut(nth)?.as_mut()?.heartbeat.poll(now, time)?;
            Some(node)
        })
    }

    /// Returns the next node that was silent on both buses for ten consumer times and did not answer before, or since
    /// its last boot-up message. Each once.
    pub fn next_forgotten(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        let is_over = |peer: &Peer| peer.forgotten_at(consumer).is_some_and(|at| at <= now);
        let (node, _) = self.each().find(|(node, peer)| is_over(peer) && self.is_forgettable(*node))?;
        self.forget(node);
        Some(node)
    }

    /// Returns the next assigned slave that was never heard, each once.
    pub fn next_unheard(&mut self) -> Option<NodeId> {
        let node = first(self.unheard)?;
        self.unheard &= !node_bit(node);
        Some(node)
    }

    /// Slaves that count and are silent on the active bus, and those that are heard there.
    pub(super) fn silent_and_heard(&self, now: Instant) -> (NodeSet, NodeSet) {
        let (mut silent, mut heard) = (0, 0);
        for (node, peer) in self.each_counted() {
            let set = if peer.silent_at <= now { &mut silent } else { &mut heard };
            *set |= node_bit(node);
        }
        (silent, heard)
    }

    /// Returns whether a slave that counts is silent on the active bus and heard on the other one for the hold
    /// time.
    pub fn is_any_elsewhere(&self, now: Instant, parameters: &Parameters) -> bool {
        self.each_counted().any(|(_, peer)| peer.is_elsewhere(now, parameters))
    }

    /// Notes that every check was made at `now`: finds the next instant with something due.
    pub fn checked(&mut self, now: Instant, parameters: &Parameters) {
        let mut next = Instant::NEVER;
        let mut add = |due: Instant| {
            if due > now && due < next {
                next = due;
            }
        };
        for (node, peer) in self.each() {
            if let Some(due) = peer.heartbeat.deadline(self.time(node, parameters.consumer)) {
                add(due);
            }
            if self.is_forgettable(node)
                && let Some(due) = peer.forgotten_at(parameters.consumer)
            {
                add(due);
            }
        }
        for (_, peer) in self.each_counted() {
            add(peer.silent_at);
            add(peer.elsewhere_at(parameters));
        }
        self.check = (next < Instant::NEVER).then_some(next);
    }

    /// Returns the next instant at which a node may have something due.
    pub fn deadline(&self) -> Option<Instant> {
        self.check
    }

    /// Returns the last state of a node. `None` if it was never heard, is lost or forgotten.
    pub fn state(&self, node: NodeId) -> Option<NmtState> {
        let peer = self.place(node)?;
        (!peer.heartbeat.is_missed()).then_some(peer.state)
    }

    /// Returns the end of the last heartbeat of a node, if that reported Operational.
    pub fn operational_at(&self, node: NodeId) -> Option<Instant> {
        self.place(node).filter(|peer| peer.state == NmtState::Operational)?.heartbeat.last()
    }

    const fn counted(&self) -> NodeSet {
        self.assigned | self.answered | self.adopted
    }

    /// Returns whether silence makes the master forget this node.
    const fn is_forgettable(&self, node: NodeId) -> bool {
        !self.assigned & (!self.counted() | self.rebooted) & node_bit(node) != 0
    }

    /// Returns the nodes that count and were heard.
    fn each_counted(&self) -> impl Iterator<Item = (NodeId, &Peer)> {
        self.each_of(self.counted())
    }

    /// Returns those of `nodes` that were heard.
    fn each_of(&self, nodes: NodeSet) -> impl Iterator<Item = (NodeId, &Peer)> {
        let mut rest = nodes;
        let each = core::iter::from_fn(move || {
            let node = first(rest)?;
            rest &= !node_bit(node);
            Some(node)
        });
        each.filter_map(|node| Some((node, self.place(node)?)))
    }

    fn forget(&mut self, node: NodeId) {
        if let Some(place) = self.places.get_mut(usize::from(node.get())) {
            *place = None;
        }
        let answers = [&mut self.answered, &mut self.adopted, &mut self.rebooted];
        let rest = [&mut self.unasked, &mut self.ready, &mut self.unheard];
        for set in answers.into_iter().chain(rest) {
            *set &= !node_bit(node);
        }
    }

    fn place(&self, node: NodeId) -> Option<&Peer> {
        self.places.get(usize::from(node.get()))?.as_ref()
    }

    fn each(&self) -> impl Iterator<Item = (NodeId, &Peer)> {
        self.places.iter().zip(0_u8..).filter_map(|(place, raw)| Some((NodeId::new(raw)?, place.as_ref()?)))
    }
}

const fn node_bit(node: NodeId) -> NodeSet {
    1 << (node.get() & 0x7F)
}

/// The lowest Node-ID of a set.
fn first(nodes: NodeSet) -> Option<NodeId> {
    NodeId::new(nodes.trailing_zeros() as u8)
}
