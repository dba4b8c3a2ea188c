//! Budget of a slave: above it the slave is silent for a time (ECSS 5.3.3.1b).

use super::{Out, Slave};
use crate::link::budget::{BudgetStep, Over};
use crate::node::{Device, SlaveEvent};
use crate::types::{CobId, Instant};

impl<D: Device> Slave<D> {
    /// A frame was refused.
    #[inline(never)] // seldom
    pub(super) fn on_over_budget(&mut self, id: CobId, over: Over, now: Instant, out: &mut Out) {
        if self.canopen.services.over_budget(id, over, now) {
            out.event(SlaveEvent::OverBudget { id });
        }
        if over == Over::Node {
            let (redundancy, mut node) = self.split(now, out);
            redundancy.silence(&mut node);
        }
    }

    pub(super) fn run_budget(&mut self, until: Instant, now: Instant, out: &mut Out) {
        match self.budget.poll(until) {
            Some(BudgetStep::Resume) => {
                let (redundancy, mut node) = self.split(now, out);
                redundancy.resume(now, &mut node);
            }
            Some(BudgetStep::Calm) => self.canopen.services.within_budget(),
            None => {}
        }
    }
}
