//! Nodes that send too much: the master itself, and its slaves (ECSS 5.3.3.1b).

use async_canopen::node::extend::Part;

use super::{Master, MasterEvent, Turn};
use crate::emcy::ErrorCode;
use crate::link::budget::{Budget, BudgetStep, Over, is_sdo};
use crate::nmt::{Command, NmtMessage, Target};
use crate::node::SpacecraftDevice;
use crate::node::services::BudgetServices;
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
}

impl Part for Budgets {
    fn earliest(&self) -> Option<Instant> {
        earliest(&[self.own.deadline(), self.slaves.deadline()])
    }
}

impl<D: SpacecraftDevice, B: MasterBoards> Master<D, B> {
    /// A frame is to go out. Silence is Pre-operational: no PDO, and no frame of the application. What the network
    /// lives on has bounds of its own and goes on: slaves that miss their master would search it.
    pub(super) fn takes_token(&mut self, id: CobId, turn: &mut Turn) -> bool {
        let Some(over) = self.budgets.no_sooner().own.take(id, turn.now) else { return true };
        self.budgets.settle(self.services.wakes_mut());
        if self.services.over_budget(id, over) {
            turn.out.event(MasterEvent::OverBudget { id });
        }
        if over == Over::Node {
            self.on_own_command(Command::EnterPreOperational, turn);
        }
        false
    }

    /// A frame of a node. One that does not count as a slave decides nothing. SDO does not count: another client
    /// may have a transfer with it.
    pub(super) fn watch(&mut self, bus: Bus, id: CobId, node: NodeId, at: Instant, turn: &mut Turn) {
        if bus != self.redundancy.active() || is_sdo(id) || !self.redundancy.peers().counts(node) {
            return;
        }
        let is_held = self.redundancy.peers().is_held(node);
        let wakes = self.services.wakes_mut();
        let step = self.budgets.step(wakes, |budgets| budgets.slaves.on_frame(node, is_held, at));
        if let Some(step) = step {
            self.silence(node, step, turn);
        }
    }

    fn silence(&mut self, node: NodeId, step: BabblingStep, turn: &mut Turn) {
        let target = Target::Node(node);
        match step {
            BabblingStep::Stopped => {
                self.redundancy_mut().peers_mut().hold(target, true);
                self.boot_mut().on_commanded(target);
                self.services.raise(ErrorCode::MONITORING, [node.get(), 0, 0, 0, 0]);
                self.send_nmt(NmtMessage { command: Command::Stop, target }, turn);
            }
            BabblingStep::Reset => {
                _ = self.send_nmt(NmtMessage { command: Command::ResetNode, target }, turn)
            }
            BabblingStep::BusLeft => {
                let other = self.redundancy.active().other();
                self.redundancy_mut().request(other);
            }
            BabblingStep::Quiet => {}
        }
        turn.out.event(MasterEvent::Babbling { node, step });
    }

    /// Ends the silence, and what was reported.
    pub(super) fn run_budget(&mut self, turn: &mut Turn) {
        match self.budgets.no_sooner().own.poll(turn.until) {
            Some(BudgetStep::Resume) => self.on_own_command(Command::Start, turn),
            Some(BudgetStep::Calm) => self.services.within_budget(),
            None => {}
        }
        while let Some((node, was_held)) = self.budgets.no_sooner().slaves.poll(turn.until) {
            self.redundancy_mut().peers_mut().hold(Target::Node(node), was_held);
            self.end_babbling(node, turn);
        }
    }

    /// The application commands slaves, babbling or not.
    pub(super) fn on_application_command(&mut self, target: Target, turn: &mut Turn) {
        while let Some(node) = self.budgets.no_sooner().slaves.on_commanded(target) {
            self.end_babbling(node, turn);
        }
    }

    fn end_babbling(&mut self, node: NodeId, turn: &mut Turn) {
        self.services.clear(ErrorCode::MONITORING, node.get());
        turn.out.event(MasterEvent::Babbling { node, step: BabblingStep::Quiet });
    }
}
