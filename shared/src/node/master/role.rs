//! The role of a master board: standby or active (ECSS 8.1a, Figure 4-2).
//!
//! A standby sends no dominant bit. It follows the active master: the bus of its heartbeat, the states of the
//! slaves, and the spacecraft time. So the time continues when it takes over.

use super::boards::MasterBoards;
use super::{Master, MasterEvent, Out};
use crate::emcy::ErrorCode;
use crate::heartbeat;
use crate::link::Stamp;
use crate::nmt::NmtSlave;
use crate::node::Device;
use crate::node::MasterRole;
use crate::redundancy::{Answer, Claim, Rivals, Role, RoleCause, RoleChange, Standby};
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// Returns whether the board manages the network. `false` while it listens or is the standby.
    #[inline(always)] // constant for one board
    pub fn is_active(&self) -> bool {
        self.boards.standby().is_none_or(Standby::is_active)
    }

    /// Returns the COB-ID of the spacecraft time while it must not be sent.
    ///
    /// That is so if this board took over before it received a time: the slaves have the time of the other board.
    /// It ends when the clock is set by [`MasterRequest::SetTime`](crate::node::MasterRequest::SetTime) or by a
    /// client (2010h, 2012h). Always `None` with one master board.
    #[inline(always)] // constant for one board
    pub fn withheld_time(&self) -> Option<CobId> {
        let is_known = self.boards.standby().is_none_or(Standby::has_begun);
        if is_known || self.services.time.clock().is_set() {
            return None;
        }
        self.services.time_pdo().map(|pdo| pdo.id)
    }

    /// Power-on of one of two boards: it listens, silent on both buses. Whether it is one.
    pub(super) fn listen(&mut self, now: Instant, out: &mut Out) -> bool {
        let Some(standby) = self.boards.standby_mut() else { return false };
        standby.start(now);
        self.services.configure(now);
        self.services.buses.listen(out);
        self.show_role();
        self.services.next = now;
        true
    }

    /// Returns when a standby takes over.
    pub(super) fn role_deadline(&self) -> Option<Instant> {
        self.boards.standby()?.deadline()
    }

    /// Becomes active when it is due.
    pub(super) fn run_role(&mut self, until: Instant, now: Instant, out: &mut Out) {
        let Some(standby) = self.boards.standby_mut() else { return };
        let Some(change) = standby.poll(until) else { return };
        let bus = standby.heard().unwrap_or(self.manager.parameters().bdefault);
        self.manager.take_over(bus, standby.overheard(), now);
        self.services.show_redundancy(self.manager.parameters(), now);
        self.services.buses.join(bus, out);
        self.boot_up(now, out);
        self.boot.start(now);
        self.on_role(change, out);
    }

    /// Becomes the standby of another active master: frames that wait are discarded.
    pub(super) fn stand_by(&mut self, change: RoleChange, now: Instant, out: &mut Out) {
        let bus = self.manager.active();
        while self.held.pop_front().is_some() {
            self.services.buses.left(bus);
        }
        self.is_time_pending = false;
        self.services.buses.listen(out);
        self.drop_transfers(now);
        self.manager.stand_by();
        self.boot.stand_by();
        self.identification = super::Identification::default();
        self.rivals = Rivals::default();
        self.end_clashes(Instant::NEVER, out);
        Bus::ALL.into_iter().for_each(|bus| self.services.clear(ErrorCode::CAN_ID_COLLISION, bus.bdefault()));
        self.nmt = NmtSlave::new(true);
        self.entered(NmtState::Initialising, now, out);
        self.on_role(change, out);
    }

    fn on_role(&mut self, change: RoleChange, out: &mut Out) {
        self.services.next = Instant::ZERO;
        self.show_role();
        out.event(MasterEvent::Role(change));
    }

    /// Object 2045h.
    fn show_role(&mut self) {
        let Some(standby) = self.boards.standby() else { return };
        let (role, strap) = (standby.role() as u8, standby.strap() as u8);
        let shown: &mut MasterRole = &mut self.services.dictionary.objects.application.network.role;
        if role == Role::Active as u8 && shown.role != role {
            shown.taken = shown.taken.saturating_add(1);
        }
        (shown.role, shown.strap) = (role, strap);
    }

    /// Takes a frame while another master is active.
    pub(super) fn overhear(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let id = frame.id();
        if id == CobId::heartbeat(NodeId::MASTER) {
            self.manager.follow(bus);
            return self.on_other_master(bus, stamp.at, now, out);
        }
        if self.on_claim(bus, frame, stamp.at, now, out) {
            return;
        }
        if self.is_of_master(id) {
            return self.overhear_unacknowledged(bus, frame, stamp, now, out);
        }
        let Some(node) = id.node().filter(|node| *node != NodeId::MASTER) else {
            return self.services.buses.ignored(bus);
        };
        if id == CobId::heartbeat(node) {
            let Some(state) = heartbeat::decode(frame) else { return self.services.buses.malformed(bus) };
            let heard = self.manager.on_heartbeat(bus, node, state, stamp.at);
            self.boot.on_overheard(node, state);
            if state == NmtState::Operational
                && bus == self.manager.active()
                && let Some(standby) = self.boards.standby_mut()
            {
                standby.on_operational(node);
            }
            if heard.changed {
                self.show_state(node, state.byte());
                out.event(MasterEvent::SlaveState { node, bus, state });
            }
        } else if bus == self.manager.active() && id == CobId::sdo_response(node) {
            // An answer to the active master: it is a slave.
            self.manager.on_answer(node, stamp.at);
        } else {
            self.services.buses.ignored(bus);
        }
    }

    /// Returns whether only an active master sends this beside heartbeat and claims: SYNC, the spacecraft time.
    fn is_of_master(&self, id: CobId) -> bool {
        id == self.sync.id() || self.services.time_pdo().is_some_and(|pdo| pdo.id == id)
    }

    /// Takes a frame that only a master sends, perhaps in place of its heartbeat.
    fn overhear_unacknowledged(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        now: Instant,
        out: &mut Out,
    ) {
        let slaves = self.manager.peers().heard(stamp.at, self.manager.parameters().consumer);
        if let Some(standby) = self.boards.standby_mut() {
            let answer = standby.on_other_frame(bus, stamp.at, slaves);
            self.answer(bus, answer, now, out);
        }
        if slaves == 0 {
            self.manager.follow(bus);
        }
        if bus != self.manager.active() {
            self.services.buses.ignored(bus);
        } else if frame.id() == self.sync.id() {
            self.boot.on_sync_overheard();
            // A wrong length is reported by the master that is active.
            let _ = self.services.on_sync(bus, frame, stamp);
        } else if !self.services.overhear_time(frame, stamp, now, out) {
            self.services.buses.ignored(bus);
        }
    }

    /// Takes the heartbeat of another active master.
    pub(super) fn on_other_master(&mut self, bus: Bus, at: Instant, now: Instant, out: &mut Out) {
        if let Some(standby) = self.boards.standby_mut() {
            let answer = standby.on_master(bus, at);
            self.answer(bus, answer, now, out);
        }
    }

    /// Takes a frame that may be a claim of another active master. Returns whether it was one.
    #[inline(always)] // nothing for one board
    pub(super) fn on_claim(
        &mut self,
        bus: Bus,
        frame: &Frame,
        at: Instant,
        now: Instant,
        out: &mut Out,
    ) -> bool {
        match self.boards.standby().and_then(|standby| standby.pair().claim(frame)) {
            Some(claim) => {
                self.take_claim(bus, &claim, at, now, out);
                true
            }
            None => false,
        }
    }

    fn take_claim(&mut self, bus: Bus, claim: &Claim, at: Instant, now: Instant, out: &mut Out) {
        let slaves = self.manager.peers().heard(at, self.manager.parameters().consumer);
        if let Some(standby) = self.boards.standby_mut() {
            let answer = standby.on_claim(bus, claim, at, slaves);
            self.answer(bus, answer, now, out);
        }
    }

    fn answer(&mut self, bus: Bus, answer: Answer, now: Instant, out: &mut Out) {
        match answer {
            Answer::Nothing => {}
            Answer::Changed(change) if change.cause == RoleCause::MasterHeard => self.on_role(change, out),
            Answer::Changed(change) => self.stand_by(change, now, out),
            Answer::Claim(claim) => {
                if let Some(standby) = self.boards.standby() {
                    out.send_for(bus, standby.pair().frame(claim), now, self.services.lifetimes.heartbeat);
                }
            }
        }
    }

    /// Sends a claim on both buses with each heartbeat: the other board hears that this one is active. On the
    /// active bus it goes after the heartbeat that announces this master there.
    #[inline(always)] // nothing for one board
    pub(super) fn call_standby(&mut self, now: Instant, out: &mut Out) {
        let slaves = || self.manager.peers().heard(now, self.manager.parameters().consumer);
        let Some(standby) = self.boards.standby_mut() else { return };
        let Some(claim) = standby.call(now, slaves()) else { return };
        let frame = standby.pair().frame(claim);
        let (active, lifetime) = (self.manager.active(), self.services.lifetimes.heartbeat);
        if self.services.buses.is_joined(active.other(), active) {
            out.send_for(active.other(), frame, now, lifetime);
        }
        self.send(frame, now, lifetime, out);
    }

    /// Becomes the standby by command. Ignored where there is one board, or this one is not active.
    pub(super) fn stand_by_commanded(&mut self, now: Instant, out: &mut Out) {
        if let Some(standby) = self.boards.standby_mut().filter(|standby| standby.is_active()) {
            let change = standby.stand_by(now, RoleCause::Commanded);
            self.stand_by(change, now, out);
        }
    }
}
