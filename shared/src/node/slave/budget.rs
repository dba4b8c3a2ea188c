//! Budget of a slave: above it the slave is silent for a time (ECSS 5.3.3.1b).

use super::{Out, Slave};
use crate::link::budget::{BudgetStep, Over};
use crate::node::{Device, SlaveEvent};
use crate::types::{CobId, Instant};

impl<D: Device> Slave<D> {
    /// A frame was refused. Silence is Pre-operational without a way out but a reset: no PDO, while the master
    /// hears the node and may ask it.
    #[inline(never)] // seldom
    pub(super) fn on_over_budget(&mut self, id: CobId, over: Over, now: Instant, out: &mut Out) {
        if self.canopen.services.over_budget(id, over, now) {
            out.event(SlaveEvent::OverBudget { id });
        }
        if over == Over::Node {
            self.enter_pre_operational(now, out);
        }
    }

    /// Silence ends with the communication profile of power-on, whatever a client had written to make the node babble.
    pub(super) fn run_budget(&mut self, until: Instant, now: Instant, out: &mut Out) {
        match self.budget.poll(until) {
            Some(BudgetStep::Resume) => self.boot(now, out),
            Some(BudgetStep::Calm) => self.canopen.services.within_budget(),
            None => {}
        }
    }
}
