//! State of a node over time as observed on the wires.

use can_twin::wire::time::Time;

use super::change::Change;
use super::follow::{Follow, SETTLING};
use super::liveness::Liveness;
use super::meaning::{NmtCommand, NmtState};
use super::phase::{Phase, Span};
use super::plan::BusAccess;
use super::record::{Bus, Node};

/// A node under observation.
#[derive(Clone, Debug)]
pub struct Track {
    /// Bus access; `None` for the master.
    pub access: Option<BusAccess>,
    /// A slave of the minimal set (ECSS 9): operational as long as it has power; it ignores NMT.
    pub is_minimal: bool,
    /// It has one controller and two transceivers.
    pub has_one_controller: bool,
    /// All spans, oldest first, never empty.
    pub spans: Vec<Span>,
    /// Number of commands that it had to execute.
    pub tc_due: u64,
    /// Number of resets of the node commanded by the master.
    pub resets_due: u64,
    /// Time from the cut until it worked on the other bus, see [`Change::Recovered`]. `None` also where the active
    /// master was lost before.
    pub failover: Option<Time>,
    /// Time from the loss of the active master until it worked for the other one.
    pub takeover: Option<Time>,
    pub(super) liveness: Liveness,
    pub(super) follow: Follow,
    pub(super) master_heard: Option<Time>,
    pub(super) settled: Time,
}

impl Track {
    /// Makes the track of a node without power.
    pub(super) fn new(access: Option<BusAccess>) -> Self {
        let off = Span { from: Time::ZERO, phase: Phase::Off, bus: Bus::Nominal };
        Track {
            access,
            is_minimal: false,
            has_one_controller: false,
            spans: vec![off],
            tc_due: 0,
            resets_due: 0,
            failover: None,
            takeover: None,
            liveness: Liveness::default(),
            follow: Follow::default(),
            master_heard: None,
            settled: Time::ZERO,
        }
    }

    /// Returns the access of a slave: as planned for a shipped image, as observed for an image of the user's.
    pub fn seen_access(&self) -> Option<BusAccess> {
        match self.access {
            Some(BusAccess::Unknown) => self.follow.found(),
            planned => planned,
        }
    }

    /// Returns the bus on which the node worked at an instant.
    pub fn bus_at(&self, at: Time) -> Bus {
        self.spans.iter().rev().find(|span| span.from <= at).unwrap_or(&self.spans[0]).bus
    }

    /// Returns the bus access of the node as text; empty for a master, and while it is unknown. A node with one controller has
    /// selective access.
    pub fn kind(&self) -> String {
        let access = self.seen_access().map_or("", BusAccess::name);
        let access = if self.has_one_controller { "1 controller" } else { access };
        if self.is_minimal { format!("{access}, minimal") } else { access.to_owned() }
    }

    /// Returns the name of one of its phases in texts. The role of a master board is active, not operational.
    pub fn name_of(&self, phase: Phase) -> &'static str {
        match (self.access, phase) {
            (None, Phase::Nmt(NmtState::Operational)) => "active",
            _ => phase.name(),
        }
    }

    /// Returns the present span.
    pub fn now(&self) -> Span {
        *self.spans.last().expect("a track begins with a span")
    }

    /// Returns the bus on which it is operational by all observations.
    pub fn operational_on(&self) -> Option<Bus> {
        let now = self.now();
        (now.phase == Phase::Nmt(NmtState::Operational)).then_some(now.bus)
    }

    pub(super) fn enter(&mut self, node: Node, span: Span, changes: &mut Vec<Change>) {
        let now = self.now();
        if (now.phase, now.bus) != (span.phase, span.bus) {
            self.spans.push(span);
            changes.push(Change::Now(node, span));
        }
    }

    /// Sets the phase to silent if it is operational and its heartbeats have stopped before `now`.
    pub(super) fn fall_silent(&mut self, node: Node, now: Time, changes: &mut Vec<Change>) {
        let current = self.now();
        if current.phase == Phase::Nmt(NmtState::Operational)
            && let Some(at) = self.liveness.silent_at().filter(|at| *at < now)
        {
            let span = Span { from: at.max(current.from), phase: Phase::Silent, bus: current.bus };
            self.enter(node, span, changes);
        }
    }

    /// Applies an NMT command. For a silent node the next heartbeat shows whether it was executed.
    pub(super) fn obey(&mut self, node: Node, at: Time, command: NmtCommand, changes: &mut Vec<Change>) {
        self.resets_due += u64::from(command == NmtCommand::ResetNode);
        if self.now().phase == Phase::Silent {
            return;
        }
        let phase = match command {
            NmtCommand::Start => Phase::Nmt(NmtState::Operational),
            NmtCommand::Stop => Phase::Nmt(NmtState::Stopped),
            NmtCommand::EnterPreOperational => Phase::Nmt(NmtState::PreOperational),
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => Phase::Starting,
        };
        let bus = self.now().bus;
        self.settled = at + SETTLING;
        self.enter(node, Span { from: at, phase, bus }, changes);
    }
}
