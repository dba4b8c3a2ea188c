//! Budget of a slave: above it the slave is silent for a time (ECSS 5.3.3.1b).

use super::Slave;
use crate::link::budget::{BudgetStep, Over};
use crate::node::services::BudgetServices;
use crate::node::slave::Turn;
use crate::node::{SlaveEvent, SpacecraftDevice};
use crate::types::CobId;

impl<D: SpacecraftDevice> Slave<D> {
    /// A frame was refused.
    #[inline(never)] // seldom
    pub(super) fn on_over_budget(&mut self, id: CobId, over: Over, turn: &mut Turn) {
        self.budget.settle(self.canopen.wakes_mut());
        if self.canopen.services_mut().over_budget(id, over) {
            turn.out.event(SlaveEvent::OverBudget { id });
        }
        if over == Over::Node {
            self.decide(turn, |redundancy, step| redundancy.silence(step));
        }
    }

    pub(super) fn run_budget(&mut self, turn: &mut Turn) {
        match self.budget.no_sooner().poll(turn.until) {
            Some(BudgetStep::Resume) => {
                self.redundancy.no_sooner().resume();
                // ECSS 6.10k: the boot-up message has the Node-ID.
                self.canopen.check_node_id();
                self.boot(turn);
            }
            Some(BudgetStep::Calm) => self.canopen.services_mut().within_budget(),
            None => {}
        }
    }
}
