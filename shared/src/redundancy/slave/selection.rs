//! Effect of a decision of the selector on bus and NMT state.

use super::{BusCause, SlaveAction as Action, SlaveRedundancy, SlaveStep};
use crate::emcy::ErrorCode;
use crate::redundancy::Selection;
use crate::types::{Bus, NodeId};

/// Source of errors of the master.
const MASTER: u8 = NodeId::MASTER.get();

impl SlaveRedundancy {
    pub(super) fn apply(&mut self, selection: Selection, step: &mut SlaveStep) {
        match selection {
            Selection::Missed { bus } => {
                step.act(Action::MasterMissed { bus });
                // ECSS 8.3.3e, note 2.
                step.act(Action::Raise { code: ErrorCode::HEARTBEAT, source: MASTER });
                self.warning = Some(step.now + self.warning_time);
                self.enter_pre_operational(step);
            }
            Selection::Toggled { to } => {
                self.enter_pre_operational(step);
                self.use_bus(to, true, BusCause::Toggled, step);
            }
            Selection::GaveUp { bus } => step.act(Action::GaveUp { bus }),
            Selection::Found { bus, moved } => {
                self.confirm(step);
                self.use_bus(bus, moved, BusCause::Found, step);
            }
            Selection::Confirmed => self.confirm(step),
            Selection::Unconfirmed { bus, moved } => {
                self.enter_pre_operational(step);
                self.use_bus(bus, moved, BusCause::Unconfirmed, step);
            }
            Selection::Followed { to } => {
                self.use_bus(to, true, BusCause::Followed, step);
                self.retain_bdefault(step);
            }
            Selection::Contradicted { bus, moved } => {
                step.act(Action::Raise { code: ErrorCode::CAN_ID_COLLISION, source: MASTER });
                if moved {
                    self.use_bus(bus, true, BusCause::TakenBack, step);
                    self.retain_bdefault(step);
                }
            }
            Selection::Undisputed => {
                step.act(Action::Clear { code: ErrorCode::CAN_ID_COLLISION, source: MASTER });
            }
            Selection::KeepBdefault { bus } => self.keep_bdefault(bus, step),
        }
        step.act(Action::ShowParameters);
    }

    /// The master is there, as its heartbeat shows. A command alone may come from any node.
    fn confirm(&mut self, step: &mut SlaveStep) {
        self.warning = None;
        if self.selector.is_confirmed() {
            self.retain_bdefault(step);
            step.act(Action::Clear { code: ErrorCode::HEARTBEAT, source: MASTER });
        }
    }

    /// The application of a slave with selective access chose a bus (ECSS 8.2.3a).
    pub(super) fn change_bus(&mut self, bus: Bus, step: &mut SlaveStep) {
        let moved = self.selector.select(bus, step.now);
        self.enter_pre_operational(step);
        self.use_bus(bus, moved, BusCause::Selected, step);
        step.act(Action::ShowParameters);
    }

    pub(super) fn enter_pre_operational(&mut self, step: &mut SlaveStep) {
        if !self.clashes.has_yielded() {
            step.act(Action::EnterPreOperational);
        }
    }

    /// The heartbeat continues on a new bus at once (ECSS 8.3.3d, h).
    fn use_bus(&mut self, bus: Bus, is_new: bool, cause: BusCause, step: &mut SlaveStep) {
        if is_new && !self.clashes.has_yielded() {
            step.act(Action::Announce);
        }
        step.act(Action::ActiveBus { bus, cause, is_new });
    }
}
