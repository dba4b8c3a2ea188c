//! Effect of a decision of the selector on bus and NMT state.

use super::{BusCause, SlaveAction as Action, SlaveNode, SlaveRedundancy};
use crate::emcy::ErrorCode;
use crate::nmt::Reaction;
use crate::redundancy::Selection;
use crate::types::{Bus, Instant, NodeId};

/// Source of errors of the master.
const MASTER: u8 = NodeId::MASTER.get();

impl SlaveRedundancy {
    pub(super) fn apply(&mut self, selection: Selection, now: Instant, node: &mut impl SlaveNode) {
        match selection {
            Selection::Missed { bus } => {
                node.act(Action::MasterMissed { bus });
                // ECSS 8.3.3e, note 2.
                node.act(Action::Raise { code: ErrorCode::HEARTBEAT, source: MASTER });
                self.warning = Some(now + self.warning_time);
                self.enter_pre_operational(node);
            }
            Selection::Toggled { to } => {
                self.enter_pre_operational(node);
                self.use_bus(to, true, BusCause::Toggled, now, node);
            }
            Selection::GaveUp { bus } => node.act(Action::GaveUp { bus }),
            Selection::Found { bus, moved } => {
                self.confirm(node);
                self.use_bus(bus, moved, BusCause::Found, now, node);
            }
            Selection::Confirmed => self.confirm(node),
            Selection::Unconfirmed { bus, moved } => {
                self.enter_pre_operational(node);
                self.use_bus(bus, moved, BusCause::Unconfirmed, now, node);
            }
            Selection::Followed { to } => {
                self.use_bus(to, true, BusCause::Followed, now, node);
                self.retain_bdefault(node);
            }
            Selection::Contradicted { bus, moved } => {
                node.act(Action::Raise { code: ErrorCode::CAN_ID_COLLISION, source: MASTER });
                if moved {
                    self.use_bus(bus, true, BusCause::TakenBack, now, node);
                    self.retain_bdefault(node);
                }
            }
            Selection::Undisputed => {
                node.act(Action::Clear { code: ErrorCode::CAN_ID_COLLISION, source: MASTER });
            }
            Selection::KeepBdefault { bus } => self.keep_bdefault(bus, node),
        }
        node.show(self.selector.parameters());
    }

    /// The master is there, as its heartbeat shows. A command alone may come from any node.
    fn confirm(&mut self, node: &mut impl SlaveNode) {
        self.warning = None;
        if self.selector.is_confirmed() {
            self.retain_bdefault(node);
            node.act(Action::Clear { code: ErrorCode::HEARTBEAT, source: MASTER });
        }
    }

    /// The application of a slave with selective access chose a bus (ECSS 8.2.3a).
    pub(super) fn change_bus(&mut self, bus: Bus, now: Instant, node: &mut impl SlaveNode) {
        let moved = self.selector.select(bus, now);
        self.enter_pre_operational(node);
        self.use_bus(bus, moved, BusCause::Selected, now, node);
        node.show(self.selector.parameters());
    }

    pub(super) fn enter_pre_operational(&mut self, node: &mut impl SlaveNode) {
        if self.clashes.has_yielded() {
            return;
        }
        let reaction = node.control_mut().on_master_missed();
        if let Reaction::Entered(state) = reaction {
            node.act(Action::Entered(state));
        }
    }

    /// The heartbeat continues on a new bus at once (ECSS 8.3.3d, h).
    fn use_bus(&mut self, bus: Bus, is_new: bool, cause: BusCause, now: Instant, node: &mut impl SlaveNode) {
        if is_new && !self.clashes.has_yielded() {
            node.control_mut().announce(now);
        }
        node.act(Action::ActiveBus { bus, cause, is_new });
    }
}
