//! What is due in a master, and when: each part that has a deadline is polled, and its next deadline is noted.

use async_canopen::node::extend::Part;

use super::{Master, MasterEvent, Turn};
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::SpacecraftDevice;
use crate::redundancy::MasterBoards;
use crate::types::earliest;

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// Does what is due.
    pub(super) fn run(&mut self, turn: &mut Turn) {
        if self.services.wakes().is_due(turn.until) {
            self.run_all(turn);
        }
    }

    /// Polls every service, due or not.
    pub(super) fn run_all(&mut self, turn: &mut Turn) {
        if self.is_active() {
            while let Some(bus) = self.services.buses_mut().poll(turn) {
                self.report_health(bus, turn);
                turn.out.event(MasterEvent::BusFailed { bus });
            }
            self.run_budget(turn);
        }
        while let Some(action) = self.redundancy.no_sooner().poll(turn.until, turn.now) {
            self.act(action, turn);
        }
        self.run_filters(turn);
        if self.is_active() {
            self.run_boot(turn);
            self.run_rescue(turn);
            self.run_device(turn);
            self.run_sync(turn);
        }
        self.settle();
        turn.out.note_done(turn.until);
    }

    /// Resets slaves that do not recover by themselves.
    fn run_rescue(&mut self, turn: &mut Turn) {
        if !self.redundancy.is_announced() {
            return;
        }
        let minimal = self.minimal;
        let is_minimal = |node| minimal.iter().any(|minimal| minimal.node == node);
        let stranded = self.redundancy.peers().stranded().filter(|node| !is_minimal(*node));
        if let Some(node) = self.rescue.no_sooner().poll(turn.until, stranded) {
            self.send_nmt(NmtMessage { command: Command::ResetNode, target: Target::Node(node) }, turn);
        }
    }

    fn run_sync(&mut self, turn: &mut Turn) {
        if self.produces_sync()
            && let Some(frame) = self.sync.no_sooner().poll(turn.until)
        {
            let lifetime = self.services.sync_lifetime();
            turn.out.send_for(self.redundancy.active(), frame, turn.now, lifetime);
        }
    }

    /// Notes when to poll next.
    fn settle(&mut self) {
        let of_both = earliest(&[self.filters.earliest(), self.redundancy.deadline()]);
        if !self.is_active() {
            return self.services.wakes_mut().set(of_both);
        }
        let sync = self.sync.deadline().filter(|_| self.produces_sync());
        let of_active = earliest(&[
            of_both,
            self.boot.deadline(),
            self.transfers.deadline(),
            self.identification_deadline(),
            self.errors_deadline(),
            self.budgets.earliest(),
            self.rescue.deadline().filter(|_| self.redundancy.is_announced()),
            sync,
        ]);
        self.services.settle(self.reporting_state());
        self.services.wakes_mut().note(of_active);
    }

    /// Returns whether an active master sends SYNC now.
    pub(super) fn produces_sync(&self) -> bool {
        self.redundancy.is_announced() && self.boot.is_released() && self.redundancy.state().allows_sync()
    }
}
