//! The role of a master board: standby or active (ECSS 8.1a, Figure 4-2).
//!
//! A standby sends no dominant bit. It follows the active master: the bus of its heartbeat, the states of the
//! slaves, and the spacecraft time. So the time continues when it takes over.

use super::{Master, MasterEvent, MasterServices, Turn};
use crate::emcy::{Emergency, ErrorCode};
use crate::link::Stamp;
use crate::node::MasterRole;
use crate::node::SpacecraftDevice;
use crate::node::services::{RedundancyServices, TimeServices};
use crate::redundancy::{MasterBoards, MasterVerdict, Role, RoleChange};
use crate::types::{Bus, CobId, Frame, Instant, NmtState};

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Returns whether the board manages the network. `false` while it listens or is the standby.
    #[inline(always)] // constant for one board
    pub fn is_active(&self) -> bool {
        self.redundancy.is_active()
    }

    /// Returns the COB-ID of the spacecraft time while it must not be sent.
    ///
    /// That is so if this board took over before it received a time: the slaves have the time of the other board.
    /// It ends when the clock is set by [`MasterRequest::SetTime`](crate::node::MasterRequest::SetTime) or by a
    /// client (2010h, 2012h). Always `None` with one master board.
    #[inline(always)] // constant for one board
    pub(crate) fn withheld_time(&self) -> Option<CobId> {
        let is_known = self.redundancy.standby().is_none_or(|standby| standby.has_begun());
        if is_known || self.services.time().clock().is_set() {
            return None;
        }
        self.services.time_pdo().map(|pdo| pdo.id)
    }

    /// Power-on of one of two boards: it listens, silent on both buses.
    pub(super) fn listen(&mut self, turn: &mut Turn) {
        self.services.configure(turn.now);
        self.services.buses_mut().listen(turn.out);
        self.show_role();
    }

    /// Becomes active.
    pub(super) fn take_over(&mut self, bus: Bus, turn: &mut Turn) {
        self.services.show_redundancy(self.redundancy.parameters(), turn.now);
        self.services.buses_mut().join(bus, turn.out);
        self.errors_mut().restart();
        self.boot_up(turn);
        self.boot_mut().start(turn.now);
    }

    /// Becomes the standby of another active master.
    pub(super) fn stand_by(&mut self, turn: &mut Turn) {
        self.services.buses_mut().listen(turn.out);
        self.services.emcy_mut().recall(turn.now);
        self.drop_transfers(turn.now);
        self.boot_mut().stand_by();
        *self.identification.change(self.services.wakes_mut()) = super::Identification::default();
        self.end_clashes(Instant::NEVER, turn);
        for bus in Bus::ALL {
            self.services.clear(ErrorCode::CAN_ID_COLLISION, bus.bdefault());
        }
        self.entered(NmtState::Initialising, turn);
    }

    pub(super) fn on_role(&mut self, change: RoleChange, turn: &mut Turn) {
        self.show_role();
        turn.out.event(MasterEvent::Role(change));
    }

    /// Object 2045h.
    fn show_role(&mut self) {
        let Some(standby) = self.redundancy.standby() else { return };
        let (role, strap) = (standby.role() as u8, standby.strap() as u8);
        let shown: &mut MasterRole = &mut self.services.network_mut().role;
        if role == Role::Active as u8 && shown.role != role {
            shown.taken = shown.taken.saturating_add(1);
        }
        (shown.role, shown.strap) = (role, strap);
    }

    /// Takes a frame while another master is active.
    pub(super) fn overhear(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        if self.is_of_master(frame.id()) {
            return self.overhear_unacknowledged(bus, frame, stamp, turn);
        }
        let verdict = self.redundancy_mut().on_received(bus, frame, stamp.at, turn.now);
        match verdict {
            MasterVerdict::OtherMaster(action) | MasterVerdict::Claim(action) => {
                self.services.buses_mut().count_heartbeat(bus, frame);
                self.act_if(action, turn);
            }
            MasterVerdict::Heartbeat { node, state } => {
                self.services.buses_mut().count_heartbeat(bus, frame);
                let heard = self.redundancy_mut().on_overheard(bus, node, state, stamp.at);
                self.boot_mut().on_overheard(node, state);
                if heard.changed {
                    self.show_state(node, state.byte());
                    turn.out.signal(MasterEvent::SlaveState { node, bus, state });
                }
            }
            // An answer to the active master: it is a slave.
            MasterVerdict::Response(node) => {
                self.redundancy_mut().on_answer(node, stamp.at);
            }
            MasterVerdict::Malformed => self.services.buses_mut().count_malformed(bus),
            MasterVerdict::Other => self.overhear_emergency(bus, frame, turn),
        }
    }

    /// Takes the emergencies of slaves, so that a takeover loses none.
    fn overhear_emergency(&mut self, bus: Bus, frame: &Frame, turn: &mut Turn) {
        match Emergency::decode(frame) {
            Some((node, emergency)) if self.consumes_emergency(frame.id(), node) => {
                self.follow_errors(node, &emergency, turn);
            }
            _ => self.services.buses_mut().count_ignored(bus),
        }
    }

    /// Returns whether only an active master sends this beside heartbeat and claims: SYNC, the spacecraft time.
    fn is_of_master(&self, id: CobId) -> bool {
        self.services.is_sync(id) || self.services.time_pdo().is_some_and(|pdo| pdo.id == id)
    }

    /// Takes a frame that only a master sends, perhaps in place of its heartbeat.
    fn overhear_unacknowledged(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        let action = self.redundancy_mut().on_sync_or_time(bus, stamp.at, turn.now);
        self.act_if(action, turn);
        if bus != self.redundancy.active() {
            self.services.buses_mut().count_ignored(bus);
        } else if self.services.is_sync(frame.id()) {
            self.boot_mut().on_sync_overheard();
            // A wrong length is reported by the master that is active.
            let _ = self.services.on_sync(bus, frame, stamp);
        } else if !self.services.overhear_time(frame, stamp, turn) {
            self.services.buses_mut().count_ignored(bus);
        }
    }
}
