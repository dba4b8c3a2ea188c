//! Carries out the decisions of the redundancy of a slave on the wires of the model.

use ecss_can::emcy::ErrorCode;
use ecss_can::heartbeat::machine::NodeControl;
use ecss_can::nmt::machine::Reaction;
use ecss_can::redundancy::machine::SlaveAction;
use ecss_can::redundancy::{BusCause, Parameters};
use ecss_can::types::{Bus, Instant, PerBus};
use ecss_can_worlds::judge::selector::is_bdefault_right;

use super::Slave;
use super::reports::Reports;
use crate::defect::{self, Defect};
use crate::station::Outgoing;

/// The node around the redundancy of a slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Node {
    pub control: NodeControl,
    pub outgoing: Outgoing,
    /// Frames that passed its filters.
    pub received: PerBus<u32>,
    /// Bdefault in the dictionary.
    pub bdefault: Bus,
    /// Bdefault in the parameter store.
    pub stored: Bus,
    /// Memory that outlives a reset.
    pub retained: [u32; 2],
    /// Whether its chip is to be reset.
    pub waits_for_reset: bool,
    /// End of the silence by its budget.
    pub silence: Option<Instant>,
    /// Whether an EMCY is to be sent.
    pub is_warning: bool,
    /// Whether it gave up its search and stays on its bus.
    pub has_given_up: bool,
    /// Whether Bdefault changed without a reason in the standard.
    pub has_wrong_bdefault: bool,
    /// Reports of its application.
    pub reports: Option<Reports>,
}

impl Slave {
    /// Boots up with the restored communication profile.
    pub(super) fn boot(&mut self, now: Instant) {
        let node = &mut self.node;
        node.reports.iter_mut().for_each(Reports::restart);
        let parameters = Parameters { bdefault: node.bdefault, ..defect::parameters(self.defect) };
        let bus = self.redundancy.boot(parameters, now);
        node.outgoing.send(bus, node.control.boot(now), now);
        node.has_given_up = false;
    }

    /// Carries out an action. `reported`: the bus that was reported since the parameters were shown.
    pub(super) fn carry_out(
        &mut self,
        action: SlaveAction,
        reported: &mut Option<(BusCause, Bus)>,
        now: Instant,
    ) {
        let Slave { node, redundancy, .. } = self;
        match action {
            SlaveAction::Obey(command) => {
                let reaction = node.control.on_command(command, now);
                self.follow(reaction, now);
            }
            SlaveAction::EnterPreOperational => {
                let reaction = node.control.on_master_missed();
                self.follow(reaction, now);
            }
            SlaveAction::FallSilent { .. } => {
                let reaction = node.control.fall_silent();
                self.follow(reaction, now);
            }
            SlaveAction::Announce => node.control.announce(now),
            SlaveAction::ShowParameters => {
                let reported = reported.take();
                let bdefault = defect::shown(self.defect, redundancy.parameters().bdefault, reported);
                let before = std::mem::replace(&mut node.bdefault, bdefault);
                node.has_wrong_bdefault |= !is_bdefault_right(before, bdefault, reported);
            }
            SlaveAction::NoteBdefault { bus, may_write } => {
                if may_write {
                    node.stored = bus;
                }
                node.retained = redundancy.on_noted(bus, may_write).encode();
                assert_eq!(node.stored, if may_write { bus } else { bus.other() }, "Bdefault in the store");
            }
            SlaveAction::ActiveBus { bus, cause, is_new } => {
                *reported = Some((cause, bus));
                if is_new {
                    node.outgoing.abandon(bus.other());
                    node.reports.iter_mut().for_each(Reports::leave);
                }
                let is_master = matches!(cause, BusCause::Found | BusCause::Followed | BusCause::TakenBack);
                if let Some(reports) = &mut node.reports
                    && is_master
                    && self.defect != Some(Defect::NeverAnnounces)
                {
                    reports.announce(node.control.state(), now);
                }
            }
            SlaveAction::GaveUp { .. } => node.has_given_up = true,
            SlaveAction::MasterMissed { .. } => node.has_given_up = false,
            SlaveAction::Raise { code: ErrorCode::HEARTBEAT, .. } => node.is_warning = true,
            SlaveAction::Clear { code: ErrorCode::HEARTBEAT, .. } => node.has_given_up = false,
            SlaveAction::WaitForReset => node.waits_for_reset = true,
            SlaveAction::Retain(retained) => node.retained = retained.encode(),
            _ => {}
        }
    }

    fn follow(&mut self, reaction: Reaction, now: Instant) {
        match reaction {
            Reaction::Unchanged => {}
            Reaction::Entered(state) => {
                self.node.reports.iter_mut().for_each(|reports| reports.enter(state, now));
            }
            Reaction::ResetNode => self.node.waits_for_reset = true,
            Reaction::ResetCommunication => self.boot(now),
        }
    }
}
