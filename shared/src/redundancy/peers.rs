//! Nodes that the master hears: their states, and which of them count, are lost or silent.

use self::remote::{Assignment, Heard, Question, Remote, Standing};
use super::Parameters;
use crate::heartbeat::machine::monitored;
use crate::nmt::Target;
use crate::types::{Canonical, Duration, Instant, NmtState, NodeId};

mod heard;
mod period;
mod remote;

/// Node-IDs 0..=127; those of no slave stay empty.
pub(super) const PLACES: usize = 128;
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
    remotes: [Remote; N],
    /// A node has to be asked for its device type.
    is_any_unasked: bool,
    /// No node has anything due before. Later heartbeats only move the truth further away.
    #[canonical(due)]
    check: Option<Instant>,
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
        Peers { remotes: [Remote::UNKNOWN; N], is_any_unasked: false, check: None }
    }

    /// Takes an entry of 1F81h. A slave that is removed is forgotten. It counts again when it answers.
    pub fn assign(&mut self, node: NodeId, is_slave: bool) {
        let Some(remote) = self.remote_mut(node) else { return };
        let (was_slave, is_heard) = (remote.is_assigned(), remote.heard.is_some());
        if let Some(heard) = &mut remote.heard {
            heard.period = 0;
        }
        remote.assignment = match is_slave {
            true if is_heard => Assignment::Assigned,
            true => Assignment::Awaited,
            false => Assignment::None,
        };
        if was_slave && !is_slave {
            remote.forget();
        }
        if is_heard {
            self.recheck(Instant::ZERO);
            self.find_unasked();
        }
    }

    /// Returns whether [`assign`](Self::assign) was called so for a node.
    pub(crate) fn agrees(&self, node: NodeId, is_slave: bool) -> bool {
        self.remote(node).is_none_or(|remote| remote.is_assigned() == is_slave)
    }

    /// Sets the consumer times of the entries of 1016h that are in use. Other nodes have the common one.
    pub fn set_times(&mut self, entries: &[u32]) {
        for remote in &mut self.remotes {
            remote.time = 0;
        }
        for entry in entries {
            if let Some(node) = monitored(*entry)
                && let Some(remote) = self.remote_mut(node)
            {
                remote.time = *entry as u16;
            }
        }
    }

    /// Returns whether `node` counts for the master's decisions.
    pub fn counts(&self, node: NodeId) -> bool {
        self.remote(node).is_some_and(Remote::counts)
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
        let Some(remote) = self.remote_mut(node) else { return PeerHeartbeat::default() };
        remote.observe(at, parameters.consumer);
        let (time, counts) = (remote.time(parameters.consumer), remote.counts());
        remote.end_wait();
        let is_known = remote.heard.is_some();
        let heard = remote.heard.get_or_insert_with(|| Heard::new(state, at, parameters));
        let changed = !is_known || heard.state != state;
        let returned = heard.heartbeat.on_heartbeat(at);
        heard.state = state;
        let due = heard.note_bus(active, counts, at, parameters);
        if state == NmtState::Initialising {
            heard.on_boot_up();
        }
        let is_ready = active && state.allows_sdo() && heard.question == Question::Pending;
        if is_ready {
            heard.question = Question::Ready;
        }
        let start = active && state != NmtState::Operational && !remote.is_held;
        let due = due.min(heard.heartbeat.deadline(time).unwrap_or(Instant::NEVER));
        if due < Instant::NEVER {
            self.check = Some(self.check.map_or(due, |check| check.min(due)));
        }
        if is_ready {
            self.find_unasked();
        }
        PeerHeartbeat { changed, returned, start }
    }

    /// Returns the next node whose device type (1000h) has to be read: one that is new, or booted up, or did not answer
    /// before. Nodes with fewer unanswered questions go first.
    pub fn take_unasked(&mut self) -> Option<NodeId> {
        let unasked = self.each().filter(|(_, remote, _)| remote.is_unasked());
        let (node, ..) = unasked.min_by_key(|(_, _, heard)| heard.unanswered)?;
        self.heard_mut(node)?.question = Question::None;
        self.find_unasked();
        Some(node)
    }

    /// Returns whether [`Peers::take_unasked`] has a node.
    pub const fn is_any_unasked(&self) -> bool {
        self.is_any_unasked
    }

    /// Makes a node be asked again, because the question was lost with its bus.
    pub fn ask_again(&mut self, node: NodeId) {
        if let Some(heard) = self.heard_mut(node) {
            heard.ask_again();
        }
    }

    /// Returns whether `node` left a question without an answer, so that a late answer is one.
    pub(crate) fn is_answer_late(&self, node: NodeId) -> bool {
        self.heard(node).is_some_and(|heard| heard.unanswered > 0)
    }

    /// Takes an answer of the SDO server of `node`: the node counts.
    pub(crate) fn on_answer(&mut self, node: NodeId, now: Instant) {
        let Some(heard) = self.heard_mut(node) else { return };
        heard.on_answer();
        self.find_unasked();
        self.recheck(now);
    }

    /// Takes the timeout of the question to `node`. The node is asked again when it is next heard on the active bus, up to
    /// three times. A node that was adopted, and is heard on the active bus, no longer counts after
    /// the last time. Returns `true` the first time if the node does not count, and when it no longer counts.
    pub fn on_no_answer(&mut self, node: NodeId, now: Instant) -> bool {
        let Some(heard) = self.heard_mut(node) else { return false };
        heard.unanswered = heard.unanswered.saturating_add(1);
        let mut is_news = heard.unanswered == 1;
        if heard.unanswered < QUESTIONS {
            heard.ask_again();
        } else if heard.silent_at > now && heard.standing == Standing::Adopted {
            is_news = true;
            heard.disown();
        }
        is_news && !self.counts(node)
    }

    /// Notes that the active master started `node`, which was just heard Operational on the active bus.
    pub fn on_overheard(&mut self, node: NodeId) {
        if let Some(heard) = self.heard_mut(node) {
            heard.is_overheard = true;
        }
    }

    /// Counts the nodes that were overheard as if they had answered. The master asks them anyway. Does nothing if they are
    /// more than the `claimed` slaves of the master that was active, because then one of them is a foreign node.
    pub(crate) fn adopt_overheard(&mut self, claimed: u8) {
        let overheard = self.each().filter(|(.., heard)| heard.is_overheard).count();
        for heard in self.each_heard_mut() {
            if core::mem::take(&mut heard.is_overheard) && overheard <= usize::from(claimed) {
                heard.adopt();
            }
        }
    }

    /// Notes that the active bus changed. Every node has until `silent_at` to be heard there.
    pub(crate) fn on_switch(&mut self, now: Instant, silent_at: Instant) {
        for heard in self.each_heard_mut() {
            heard.on_switch(silent_at);
        }
        self.is_any_unasked = false;
        self.recheck(now);
    }

    /// Holds slaves or releases them: a held slave is not started by the master itself. Slaves not heard yet are
    /// included.
    pub fn hold(&mut self, target: Target, is_held: bool) {
        match target {
            Target::All => self.remotes.iter_mut().for_each(|remote| remote.is_held = is_held),
            Target::Node(node) => {
                if let Some(remote) = self.remote_mut(node) {
                    remote.is_held = is_held;
                }
            }
        }
    }

    /// Returns whether the application holds this slave.
    pub(crate) fn is_held(&self, node: NodeId) -> bool {
        self.remote(node).is_some_and(|remote| remote.is_held)
    }

    /// Requests a check of every node at `now`, after a change of the bus, of the health or of the assignment.
    pub fn recheck(&mut self, now: Instant) {
        self.check = Some(now);
    }

    /// Returns whether a check is due.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        self.check.is_some_and(|check| check <= now)
    }

    /// Returns the next node whose heartbeat is overdue on both buses, each once.
    pub fn next_lost(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        self.remotes.iter_mut().zip(0..).find_map(|(remote, raw)| {
            let time = remote.time(consumer);
            remote.heard.as_mut()?.heartbeat.poll(now, time)?;
            NodeId::new(raw)
        })
    }

    /// Returns the next node that was silent on both buses for ten consumer times and did not answer before, or since
    /// its last boot-up message. Each once.
    pub(crate) fn next_forgotten(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        let is_over = |remote: &Remote| remote.forgotten_at(consumer).is_some_and(|at| at <= now);
        let (node, ..) = self.each().find(|(_, remote, _)| is_over(remote))?;
        self.remote_mut(node)?.forget();
        self.find_unasked();
        Some(node)
    }

    /// Returns the next assigned slave that was never heard, each once.
    pub(crate) fn next_unheard(&mut self) -> Option<NodeId> {
        let (remote, raw) =
            self.remotes.iter_mut().zip(0..).find(|(remote, _)| remote.assignment == Assignment::Awaited)?;
        remote.end_wait();
        NodeId::new(raw)
    }

    /// Returns the slaves that count, are not held, and are lost or in Stopped.
    pub(crate) fn stranded(&self) -> impl Iterator<Item = NodeId> {
        let is_stranded = |heard: &Heard| heard.heartbeat.is_missed() || heard.state == NmtState::Stopped;
        let all = self.each().filter(|(_, remote, _)| remote.counts() && !remote.is_held);
        all.filter(move |(.., heard)| is_stranded(heard)).map(|(node, ..)| node)
    }

    /// Slaves that count and are silent on the active bus, and those that are heard there.
    pub(super) fn silent_and_heard(&self, now: Instant) -> (NodeSet, NodeSet) {
        let (mut silent, mut heard_here) = (0, 0);
        for (node, heard) in self.each_counted() {
            let set = if heard.silent_at <= now { &mut silent } else { &mut heard_here };
            *set |= 1 << node.get();
        }
        (silent, heard_here)
    }

    /// Returns whether a slave that counts is silent on the active bus and heard on the other one for the hold
    /// time.
    pub(crate) fn is_any_elsewhere(&self, now: Instant, parameters: &Parameters) -> bool {
        self.each_counted().any(|(_, heard)| heard.is_elsewhere(now, parameters))
    }

    /// Notes that every check was made at `now`: finds the next instant with something due.
    pub fn checked(&mut self, now: Instant, parameters: &Parameters) {
        let mut next = Instant::NEVER;
        let mut add = |due: Instant| {
            if due > now && due < next {
                next = due;
            }
        };
        for (_, remote, heard) in self.each() {
            let time = remote.time(parameters.consumer);
            let missed = heard.heartbeat.deadline(time);
            [missed, remote.forgotten_at(parameters.consumer)].into_iter().flatten().for_each(&mut add);
            if remote.counts() {
                add(heard.silent_at);
                add(heard.elsewhere_at(parameters));
            }
        }
        self.check = (next < Instant::NEVER).then_some(next);
    }

    /// Returns the next instant at which a node may have something due.
    pub fn deadline(&self) -> Option<Instant> {
        self.check
    }

    /// Returns the last state of a node. `None` if it was never heard, is lost or forgotten.
    pub fn state(&self, node: NodeId) -> Option<NmtState> {
        let heard = self.heard(node)?;
        (!heard.heartbeat.is_missed()).then_some(heard.state)
    }

    /// Returns the end of the last heartbeat of a node, if that reported Operational.
    pub(crate) fn operational_at(&self, node: NodeId) -> Option<Instant> {
        self.heard(node).filter(|heard| heard.state == NmtState::Operational)?.heartbeat.last()
    }

    /// Finds out whether a node has to be asked.
    fn find_unasked(&mut self) {
        self.is_any_unasked = self.remotes.iter().any(Remote::is_unasked);
    }

    fn remote(&self, node: NodeId) -> Option<&Remote> {
        self.remotes.get(usize::from(node.get()))
    }

    fn remote_mut(&mut self, node: NodeId) -> Option<&mut Remote> {
        self.remotes.get_mut(usize::from(node.get()))
    }

    fn heard(&self, node: NodeId) -> Option<&Heard> {
        self.remote(node)?.heard.as_ref()
    }

    fn heard_mut(&mut self, node: NodeId) -> Option<&mut Heard> {
        self.remote_mut(node)?.heard.as_mut()
    }

    /// Returns the nodes that were heard.
    fn each(&self) -> impl Iterator<Item = (NodeId, &Remote, &Heard)> {
        let heard = |(remote, raw): (_, u8)| -> Option<(NodeId, &Remote, &Heard)> {
            let remote: &Remote = remote;
            Some((NodeId::new(raw)?, remote, remote.heard.as_ref()?))
        };
        self.remotes.iter().zip(0..).filter_map(heard)
    }

    /// Returns the nodes that count and were heard.
    fn each_counted(&self) -> impl Iterator<Item = (NodeId, &Heard)> {
        self.each().filter(|(_, remote, _)| remote.counts()).map(|(node, _, heard)| (node, heard))
    }

    fn each_heard_mut(&mut self) -> impl Iterator<Item = &mut Heard> {
        self.remotes.iter_mut().filter_map(|remote| remote.heard.as_mut())
    }
}
