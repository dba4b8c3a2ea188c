//! Role of a master board: active or standby (ECSS 8.1a, Figure 4-2).
//!
//! A standby follows the active master: the bus of its heartbeat, and the states of its slaves.

use super::{MasterAction, MasterBoards, MasterRedundancy, Sending};
use crate::link::machine::Outgoing;
use crate::nmt::machine::NmtSlave;
use crate::redundancy::{Claim, PeerHeartbeat, RivalReaction, Rivals, RoleCause, RoleChange, Standby};
use crate::types::{Bus, Instant, NmtState, NodeId};

impl<B: MasterBoards, const N: usize, const H: usize> MasterRedundancy<B, N, H> {
    /// Returns whether the board manages the network. `false` while it listens or is the standby.
    pub fn is_active(&self) -> bool {
        self.boards.standby().is_none_or(Standby::is_active)
    }

    /// Returns the role of this board. `None`: the mission has one master board.
    pub(crate) fn standby(&self) -> Option<&Standby> {
        self.boards.standby()
    }

    /// Becomes active when it is due.
    pub(super) fn take_over(&mut self, until: Instant, now: Instant) -> Option<MasterAction> {
        let standby = self.boards.standby_mut()?;
        let change = standby.poll(until)?;
        let bus = standby.heard().unwrap_or(self.manager.parameters().bdefault);
        self.manager.take_over(bus, standby.claimed(), now);
        Some(MasterAction::TookOver { bus, change })
    }

    /// Becomes the standby by command. Ignored where there is one board, or this one is not active.
    pub fn stand_by_commanded(&mut self, now: Instant) -> Option<MasterAction> {
        let standby = self.boards.standby_mut().filter(|standby| standby.is_active())?;
        let change = standby.stand_by(now, RoleCause::Commanded);
        Some(self.stand_by(change))
    }

    fn stand_by(&mut self, change: RoleChange) -> MasterAction {
        self.held.leave(self.active());
        self.held.is_time_due = false;
        self.due = None;
        self.manager.stand_by();
        self.rivals = Rivals::default();
        self.nmt = NmtSlave::new(true);
        self.set_state(NmtState::Initialising);
        MasterAction::StoodBy { bus: self.active(), change }
    }

    /// Number of slaves that count and are heard on the active bus.
    fn slaves(&self, at: Instant) -> u8 {
        self.manager.peers().heard_here(at, self.manager.parameters().consumer)
    }

    /// Takes 701h of another node.
    pub(super) fn on_master(&mut self, bus: Bus, at: Instant, now: Instant) -> Option<MasterAction> {
        let is_active = self.is_active();
        let answer = self.boards.standby_mut().map(|standby| standby.on_master(bus, at));
        if is_active {
            self.manager.on_rival();
            return self.rivals.on_heartbeat(bus, at).then_some(MasterAction::RivalHeard(bus));
        }
        self.manager.follow(bus);
        self.answer(bus, answer?, now)
    }

    /// Takes a SYNC or a spacecraft time of another master, as a standby. Such a frame may be sent in place of the
    /// heartbeat of a master that hears no slave.
    pub fn on_sync_or_time(&mut self, bus: Bus, at: Instant, now: Instant) -> Option<MasterAction> {
        if self.is_active() {
            return None;
        }
        let slaves = self.slaves(at);
        let answer = self.boards.standby_mut()?.on_other_frame(bus, at, slaves);
        if slaves == 0 {
            self.manager.follow(bus);
        }
        self.answer(bus, answer, now)
    }

    /// Takes a claim of another active master.
    pub(super) fn on_claim(
        &mut self,
        bus: Bus,
        claim: &Claim,
        at: Instant,
        now: Instant,
    ) -> Option<MasterAction> {
        let slaves = self.slaves(at);
        let answer = self.boards.standby_mut()?.on_claim(bus, claim, at, slaves);
        self.answer(bus, answer, now)
    }

    fn answer(&mut self, bus: Bus, answer: RivalReaction, now: Instant) -> Option<MasterAction> {
        match answer {
            RivalReaction::Nothing => None,
            RivalReaction::Changed(change) if change.cause == RoleCause::MasterHeard => {
                Some(MasterAction::HeardMaster(change))
            }
            RivalReaction::Changed(change) => Some(self.stand_by(change)),
            RivalReaction::Claim(claim) => {
                let outgoing = self.claim(claim, now)?;
                Some(MasterAction::Send { bus, outgoing })
            }
        }
    }

    /// Takes a heartbeat or boot-up message of a node, as a standby.
    pub fn on_overheard(&mut self, bus: Bus, node: NodeId, state: NmtState, at: Instant) -> PeerHeartbeat {
        let heard = self.manager.on_heartbeat(bus, node, state, at);
        if state == NmtState::Operational && bus == self.active() {
            self.manager.peers_mut().on_overheard(node);
        }
        heard
    }

    fn claim(&self, claim: Claim, now: Instant) -> Option<Outgoing> {
        let frame = self.boards.standby()?.pair().frame(claim);
        Some(Outgoing { frame, expires: now + self.lifetime() })
    }

    /// Claims with each heartbeat: the other board hears that this one is active.
    pub(super) fn call(&mut self, now: Instant) {
        if self.boards.standby().is_none() {
            return;
        }
        let (slaves, other) = (self.slaves(now), self.active().other());
        let claim = self.boards.standby_mut().and_then(|standby| standby.call(now, slaves));
        self.due = claim.map(|claim| (claim, other));
    }

    /// Sends the claim on both buses. On the active bus it follows the heartbeat that announces this master there.
    pub(super) fn next_claim(&mut self, now: Instant) -> Option<MasterAction> {
        self.boards.standby()?;
        let (claim, bus) = self.due.take()?;
        let outgoing = self.claim(claim, now)?;
        let active = self.active();
        if bus != active && self.is_joined(bus) {
            self.due = Some((claim, active));
            return Some(MasterAction::Send { bus, outgoing });
        }
        match self.send(outgoing) {
            Sending::Now(bus) => Some(MasterAction::Send { bus, outgoing }),
            Sending::Refused(bus) => Some(MasterAction::Refused(bus)),
            Sending::Held => None,
        }
    }
}
