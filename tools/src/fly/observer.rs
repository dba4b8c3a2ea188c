//! Model of the states that the slaves must have, derived from the wires only.
//!
//! A model per slave follows the frames that reached its controllers and the heartbeats it sent. In a flight of the
//! shipped images it decides which commands were due (`tc_due`) independently of the firmware; the firmware's own count
//! must agree.
//!
//! - NMT start received on a bus: operational on it. Other NMT commands: not operational.
//! - Its own heartbeat shows state and bus. Within `SETTLING` after a message of the master that changed either, it is
//!   ignored, because it may have waited in a mailbox.
//! - Parallel access: any message of the master (NMT, heartbeat, boot-up) on the other bus moves it there (ECSS
//!   8.3.3g). Selective access: it receives on one bus; its own frames show when it has changed.
//! - The master silent for the consumer time, a boot-up, a reset, no power: not operational.
//! - A master board is active from its first 701h on. It is a standby while another board sends 701h. A reset board is neither until
//!   the next 701h.
//! - A minimal slave (ECSS 9): operational from its first heartbeat on. It follows heartbeats of the master, and
//!   ignores NMT.
//! - An image of the user's: its access and its consumer time are unknown. Only its own heartbeats show its bus, its access
//!   (`follow`), and that it is alive ([`super::liveness`]). At the end of a flight the latter holds for every slave.

use std::collections::BTreeMap;

use can_twin::wire::time::Time;

use super::change::{Change, Since, Takeover};
use super::follow::SETTLING;
use super::meaning::{Meaning, NmtState, Scope};
use super::phase::{Phase, Span};
use super::plan::{BusAccess, Plan};
use super::record::{Bus, FlightEvent, MASTER, Node, Occurrence, Seen, is_master};
use super::track::Track;

/// Follows all nodes of a flight.
#[derive(Clone, Debug)]
pub struct Observer {
    /// All boards, the master first.
    pub nodes: BTreeMap<Node, Track>,
    cut: Option<(Bus, Time)>,
    /// Time at which the active one of two masters lost its power, or was reset.
    lost: Option<Time>,
    /// Board that sent the last message of a master, and its instant.
    active: Option<(Node, Time)>,
    /// Each time that another board sent 701h, oldest first.
    takeovers: Vec<Takeover>,
    consumer_time: Time,
    scope: Scope,
}

impl Observer {
    /// Makes the observer of the boards of a plan, all without power.
    pub fn new(plan: &Plan) -> Self {
        let of = |node| plan.boards.iter().find(|board| board.node == node);
        let slave = |(node, access)| {
            let is_minimal = of(node).is_some_and(|board| board.is_minimal);
            let has_one_controller = of(node).is_some_and(|board| board.has_one_controller);
            (node, Track { is_minimal, has_one_controller, ..Track::new(Some(access)) })
        };
        let mut nodes: BTreeMap<_, _> = plan.slaves().map(slave).collect();
        let masters = plan.boards.iter().map(|board| board.node).filter(|node| is_master(*node));
        nodes.extend(masters.chain([MASTER]).map(|node| (node, Track::new(None))));
        let (cut, lost, active, takeovers) = Default::default();
        let (consumer_time, scope) = (plan.consumer_time(), plan.scope());
        Observer { nodes, cut, lost, active, takeovers, consumer_time, scope }
    }

    /// Returns the master board with the last message.
    pub fn active_master(&self) -> Option<Node> {
        self.active.map(|(node, _)| node)
    }

    /// The takeover by the standby after the loss of the active master.
    pub fn takeover(&self) -> Option<Takeover> {
        let lost = self.lost?;
        self.takeovers.iter().copied().find(|takeover| takeover.first > lost)
    }

    /// The first time that a board sent 701h while the active master had power: two masters were active.
    pub fn rivalry(&self) -> Option<Takeover> {
        let is_early = |takeover: &Takeover| self.lost.is_none_or(|lost| takeover.first <= lost);
        self.takeovers.iter().copied().find(is_early)
    }

    /// The slaves.
    pub fn slaves(&self) -> impl Iterator<Item = (Node, &Track)> {
        self.nodes.iter().filter(|(node, _)| !is_master(**node)).map(|(node, track)| (*node, track))
    }

    /// Handles the next record, in chronological order.
    pub fn on(&mut self, record: &Occurrence) -> Vec<Change> {
        let mut changes = Vec::new();
        self.expire(record.at, &mut changes);
        match &record.what {
            FlightEvent::PowerOn(node) => {
                self.enter(*node, record.at, Phase::Starting, Bus::Nominal, &mut changes)
            }
            FlightEvent::PowerOff(node) => {
                self.lose(*node, record.at);
                self.nodes.entry(*node).and_modify(|track| track.liveness.on_power_off());
                let bus = self.nodes.get(node).map_or(Bus::Nominal, |track| track.now().bus);
                self.enter(*node, record.at, Phase::Off, bus, &mut changes);
            }
            FlightEvent::Reset(node) => {
                self.lose(*node, record.at);
                let bus = self.nodes.get(node).map_or(Bus::Nominal, |track| track.now().bus);
                self.enter(*node, record.at, Phase::Starting, bus, &mut changes);
            }
            FlightEvent::Cut(cut) => self.cut = Some((cut.bus, record.at)),
            FlightEvent::Frame(seen) => self.on_frame(record.at, seen, &mut changes),
            FlightEvent::Other { .. } | FlightEvent::Log { .. } => {}
        }
        changes
    }

    /// Handles the end of the flight at `end`.
    pub fn conclude(&mut self, end: Time) -> Vec<Change> {
        let mut changes = Vec::new();
        self.expire(end, &mut changes);
        for (&node, track) in self.nodes.iter_mut().filter(|(node, _)| !is_master(**node)) {
            track.fall_silent(node, end, &mut changes);
        }
        changes
    }

    /// Handles the loss of power or the reset of a board: another master may take over from the active one.
    fn lose(&mut self, board: Node, at: Time) {
        let has_other = self.nodes.keys().any(|node| is_master(*node) && *node != board);
        if has_other && self.active_master() == Some(board) {
            self.lost = Some(at);
        }
    }

    fn expire(&mut self, now: Time, changes: &mut Vec<Change>) {
        for (&node, track) in &mut self.nodes {
            if track.access == Some(BusAccess::Unknown) {
                track.fall_silent(node, now, changes);
            }
            let Some(heard) = track.master_heard else { continue };
            let deadline = heard + self.consumer_time;
            let current = track.now();
            if deadline < now && current.phase == Phase::Nmt(NmtState::Operational) {
                let phase = Phase::Nmt(NmtState::PreOperational);
                track.enter(node, Span { from: deadline, phase, bus: current.bus }, changes);
            }
        }
    }

    fn on_frame(&mut self, at: Time, seen: &Seen, changes: &mut Vec<Change>) {
        let Some(message) = seen.meaning else { return };
        match message {
            Meaning::Nmt { command, node } => {
                self.on_master(at, seen, changes);
                for (&slave, track) in &mut self.nodes {
                    let obeys = track.access.is_some() && !track.is_minimal;
                    if obeys && (node == 0 || node == slave) && seen.reached.contains(slave) {
                        track.obey(slave, at, command, changes);
                    }
                }
            }
            Meaning::BootUp { node } => {
                if node == MASTER {
                    self.on_master(at, seen, changes);
                    self.on_master_board(at, seen, changes);
                }
                let node = seen.board(node);
                let initial = Phase::Nmt(NmtState::PreOperational);
                self.enter(node, at, initial, seen.bus, changes);
                if let Some(track) = self.nodes.get_mut(&node) {
                    track.liveness.on_boot_up(at);
                    track.master_heard = None;
                    track.settled = at;
                }
            }
            Meaning::Heartbeat { node, state } => {
                if node == MASTER {
                    self.on_master(at, seen, changes);
                    self.on_master_board(at, seen, changes);
                }
                let node = seen.board(node);
                self.nodes.entry(node).and_modify(|track| {
                    track.liveness.on_heartbeat(state, seen.bus, at);
                    track.follow.on_heartbeat(seen.bus, at);
                });
                if self.nodes.get(&node).is_some_and(|track| at >= track.settled) {
                    self.enter(node, at, Phase::Nmt(state), seen.bus, changes);
                }
                let is_slave = !is_master(node) && state == NmtState::Operational;
                if self.scope == Scope::Protocol && is_slave {
                    self.recovered(node, at, seen.bus, changes);
                }
            }
            Meaning::Telecommand { node, .. } => {
                let Some(track) = self.nodes.get_mut(&node) else { return };
                if seen.reached.contains(node) && track.operational_on() == Some(seen.bus) {
                    track.tc_due += 1;
                    self.recovered(node, at, seen.bus, changes);
                }
            }
            Meaning::Telemetry { node, .. } => self.recovered(node, at, seen.bus, changes),
            // It shows no state of a node.
            _ => {}
        }
    }

    /// Handles a message that makes its bus active (ECSS 8.3.3g) for every slave whose controller received it.
    fn on_master(&mut self, at: Time, seen: &Seen, changes: &mut Vec<Change>) {
        let is_nmt = matches!(seen.meaning, Some(Meaning::Nmt { .. }));
        let is_cut = self.cut.is_some_and(|(bus, _)| bus == seen.bus);
        for (&slave, track) in &mut self.nodes {
            // A controller that is off does not receive: it has selective access. Behind a cut it shows nothing.
            if seen.reached.contains(slave) || !is_cut {
                track.follow.on_master(seen.bus, at, track.operational_on());
            }
            let Some(access) = track.access.filter(|access| *access != BusAccess::Unknown) else { continue };
            if !seen.reached.contains(slave) || track.is_minimal && is_nmt {
                continue;
            }
            let current = track.now();
            if current.bus != seen.bus {
                if access == BusAccess::Selective && track.operational_on().is_some() {
                    continue;
                }
                track.settled = at + SETTLING;
                track.enter(slave, Span { from: at, phase: current.phase, bus: seen.bus }, changes);
            }
            // Without it a minimal slave stays operational.
            track.master_heard = (!track.is_minimal).then_some(at);
        }
    }

    /// Handles 701h: its sender is the active master, another master with power is the standby.
    fn on_master_board(&mut self, at: Time, seen: &Seen, changes: &mut Vec<Change>) {
        let before = self.active.replace((seen.from, at));
        if let Some((from, last)) = before.filter(|(from, _)| *from != seen.from) {
            let takeover = Takeover { from, to: seen.from, last, first: at };
            self.takeovers.push(takeover);
            changes.push(Change::TookOver(takeover));
        }
        for (&node, track) in &mut self.nodes {
            let is_silent = matches!(track.now().phase, Phase::Starting | Phase::Standby);
            if is_master(node) && node != seen.from && is_silent {
                track.enter(node, Span { from: at, phase: Phase::Standby, bus: seen.bus }, changes);
            }
        }
    }

    fn enter(&mut self, node: Node, at: Time, phase: Phase, bus: Bus, changes: &mut Vec<Change>) {
        if let Some(track) = self.nodes.get_mut(&node) {
            track.enter(node, Span { from: at, phase, bus }, changes);
        }
    }

    fn recovered(&mut self, node: Node, at: Time, bus: Bus, changes: &mut Vec<Change>) {
        let cut = self.cut.filter(|(cut_bus, _)| *cut_bus != bus && self.lost.is_none()).map(|(_, at)| at);
        let lost = self.lost.filter(|_| self.takeover().is_some());
        let Some(track) = self.nodes.get_mut(&node) else { return };
        for (since, fault, time) in
            [(Since::Cut, cut, &mut track.failover), (Since::Loss, lost, &mut track.takeover)]
        {
            if let Some(took) = fault.map(|fault| at.since(fault)).filter(|_| time.is_none()) {
                *time = Some(took);
                changes.push(Change::Recovered(node, since, took));
            }
        }
    }
}

#[cfg(test)]
mod tests;
