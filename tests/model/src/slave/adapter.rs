//! Carries out the decisions of the redundancy of a slave on the wires of the model.

use ecss_can::emcy::ErrorCode;
use ecss_can::heartbeat::NodeControl;
use ecss_can::redundancy::{BusCause, Parameters, Retained, SlaveAction, SlaveNode};
use ecss_can::types::{Bus, Instant, PerBus};
use host_worlds::judge::selector::is_bdefault_right;

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
    /// Its chip is to be reset.
    pub waits_for_reset: bool,
    /// When the silence by its budget ends.
    pub silence: Option<Instant>,
    /// An EMCY is to be sent.
    pub is_warning: bool,
    /// It gave up its search and stays where it is.
    pub has_given_up: bool,
    /// Bdefault changed for no reason that the standard knows.
    pub has_wrong_bdefault: bool,
    /// What its application reports.
    pub reports: Option<Reports>,
}

/// The node in one step.
pub struct Adapter<'a> {
    pub node: &'a mut Node,
    /// A rule that does not hold.
    pub defect: Option<Defect>,
    pub now: Instant,
    /// The bus that was reported since the parameters were shown.
    pub reported: Option<(BusCause, Bus)>,
}

impl SlaveNode for Adapter<'_> {
    fn control(&self) -> &NodeControl {
        &self.node.control
    }

    fn control_mut(&mut self) -> &mut NodeControl {
        &mut self.node.control
    }

    fn received(&self) -> PerBus<u32> {
        self.node.received
    }

    fn restore_communication(&mut self) -> Parameters {
        self.node.reports.iter_mut().for_each(Reports::restart);
        Parameters { bdefault: self.node.bdefault, ..defect::parameters(self.defect) }
    }

    fn show(&mut self, parameters: &Parameters) {
        let reported = self.reported.take();
        let bdefault = defect::shown(self.defect, parameters.bdefault, reported);
        let before = std::mem::replace(&mut self.node.bdefault, bdefault);
        let is_right = is_bdefault_right(before, bdefault, reported);
        self.node.has_wrong_bdefault |= !is_right;
    }

    fn note_bdefault(&mut self, bus: Bus) -> Option<bool> {
        self.node.stored = bus;
        Some(true)
    }

    fn act(&mut self, action: SlaveAction) {
        let node = &mut *self.node;
        match action {
            SlaveAction::BootUp { bus } => {
                node.outgoing.send(bus, node.control.boot(self.now), self.now);
                node.has_given_up = false;
            }
            SlaveAction::ActiveBus { bus, cause, is_new } => {
                self.reported = Some((cause, bus));
                if is_new {
                    node.outgoing.abandon(bus.other());
                    node.reports.iter_mut().for_each(Reports::leave);
                }
                let is_master = matches!(cause, BusCause::Found | BusCause::Followed | BusCause::TakenBack);
                if let Some(reports) = &mut node.reports
                    && is_master
                    && self.defect != Some(Defect::NeverAnnounces)
                {
                    reports.announce(node.control.state(), self.now);
                }
            }
            SlaveAction::Entered(state) => {
                node.reports.iter_mut().for_each(|reports| reports.enter(state, self.now));
            }
            SlaveAction::GaveUp { .. } => node.has_given_up = true,
            SlaveAction::MasterMissed { .. } => node.has_given_up = false,
            SlaveAction::Raise { code: ErrorCode::HEARTBEAT, .. } => node.is_warning = true,
            SlaveAction::Clear { code: ErrorCode::HEARTBEAT, .. } => node.has_given_up = false,
            SlaveAction::BdefaultNoted { bus, is_kept } => {
                let written = Retained::decode(node.retained).map_or(0, |retained| retained.notes);
                assert_eq!(is_kept, written <= Retained::MOST_NOTES, "note {written} since power-on");
                assert_eq!(node.stored, if is_kept { bus } else { bus.other() }, "Bdefault in the store");
            }
            SlaveAction::ResetNode => node.waits_for_reset = true,
            SlaveAction::Retain(retained) => node.retained = retained.encode(),
            _ => {}
        }
    }
}
