//! Nodes that send too much: the master itself, and its slaves (ECSS 5.3.3.1b).

use super::{Master, MasterEvent, Out};
use crate::emcy::ErrorCode;
use crate::link::budget::{Budget, BudgetStep, Over, is_sdo};
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::Device;
use crate::profile::Profile;
use crate::redundancy::{Babblers, BabblingStep, MasterBoards};
use crate::types::{Bus, CobId, Instant, NodeId, earliest};

/// Budgets of the frames that the master sends, and of those that it hears from its slaves.
#[derive(Debug)]
pub(super) struct Budgets {
    own: Budget,
    pub slaves: Babblers,
}

impl Budgets {
    pub const fn new(profile: &Profile) -> Self {
        let dwell = profile.redundancy().dwell(profile.dwell);
        Budgets {
            own: Budget::of_master(&profile.budget),
            slaves: Babblers::new(profile.budget.heard, dwell),
        }
    }

    pub fn deadline(&self) -> Option<Instant> {
        earliest(&[self.own.deadline(), self.slaves.deadline()])
    }
}

impl<D: Device, B: MasterBoards> Master<D, B> {
    /// A frame is to go out. Silence is Pre-operational: no PDO, and no frame of the application. What the network
    /// lives on has bounds of its own and goes on: slaves that miss their master would search it.
    pub(super) fn takes_token(&mut self, id: CobId, now: Instant, out: &mut Out) -> bool {
        let Some(over) = self.budgets.own.take(id, now) else { return true };
        if self.services.over_budget(id, over, now) {
            out.event(MasterEvent::OverBudget { id });
        }
        if over == Over::Node {
            self.on_own_command(Command::EnterPreOperational, now, out);
        }
        false
    }

    /// A frame of a node. One that does not count as a slave decides nothing. SDO does not count: another client
    /// may have a transfer with it.
    pub(super) fn watch(
        &mut self,
        bus: Bus,
        id: CobId,
        node: NodeId,
        at: Instant,
        now: Instant,
        out: &mut Out,
    ) {
        if bus != self.redundancy.active() || is_sdo(id) || !self.redundancy.peers().counts(node) {
            return;
        }
        let is_held = self.redundancy.peers().is_held(node);
        if let Some(step) = self.budgets.slaves.on_frame(node, is_held, at) {
            self.silence(node, step, now, out);
        }
    }

    fn silence(&mut self, node: NodeId, step: BabblingStep, now: Instant, out: &mut Out) {
        let target = Target::Node(node);
        match step {
            BabblingStep::Stopped => {
                self.redundancy.peers_mut().hold(target, true);
                self.boot.on_commanded(target);
                self.services.raise(ErrorCode::MONITORING, [node.get(), 0, 0, 0, 0]);
                self.send_nmt(NmtMessage { command: Command::Stop, target }, now, out);
            }
            BabblingStep::Reset => {
                _ = self.send_nmt(NmtMessage { command: Command::ResetNode, target }, now, out)
            }
            BabblingStep::BusLeft => self.redundancy.request(self.redundancy.active().other()),
            BabblingStep::Quiet => {}
        }
        self.services.next = now;
        out.event(MasterEvent::Babbling { node, step });
    }

    /// Ends the silence, and what was reported.
    pub(super) fn run_budget(&mut self, until: Instant, now: Instant, out: &mut Out) {
        match self.budgets.own.poll(until) {
            Some(BudgetStep::Resume) => self.on_own_command(Command::Start, now, out),
            Some(BudgetStep::Calm) => self.services.within_budget(),
            None => {}
        }
        while let Some((node, was_held)) = self.budgets.slaves.poll(until) {
            self.redundancy.peers_mut().hold(Target::Node(node), was_held);
            self.end_babbling(node, out);
        }
    }

    /// The application commands slaves, babbling or not.
    pub(super) fn on_application_command(&mut self, target: Target, out: &mut Out) {
        while let Some(node) = self.budgets.slaves.on_commanded(target) {
            self.end_babbling(node, out);
        }
    }

    fn end_babbling(&mut self, node: NodeId, out: &mut Out) {
        self.services.clear(ErrorCode::MONITORING, node.get());
        out.event(MasterEvent::Babbling { node, step: BabblingStep::Quiet });
    }
}
