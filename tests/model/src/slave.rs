//! A slave of the model with the redundancy of the firmware.

mod adapter;
mod application;
pub mod reports;

use adapter::Node;
use ecss_can::emcy::ErrorCode;
use ecss_can::heartbeat::machine::NodeControl;
use ecss_can::link::access::BusAccess;
use ecss_can::redundancy::Parameters;
use ecss_can::redundancy::machine::{Retained, SlaveActions, SlaveRedundancy, SlaveStep, SlaveVerdict};
use ecss_can::types::{
    Bus, Canonical, CobId, Duration, Frame, Instant, Instants as _, NmtState, NodeId, PerBus, earliest,
};
use reports::Reports;

use crate::defect::{self, Defect};
use crate::profile::{GRACE, PARALLEL, PARAMETERS};
use crate::station::{Outgoing, Station};
use crate::what::What;

/// A slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Slave {
    id: NodeId,
    access: BusAccess,
    defect: Option<Defect>,
    redundancy: SlaveRedundancy,
    node: Node,
}

impl Slave {
    /// Makes a slave before power-on. `defect`: a broken rule.
    pub fn new(id: NodeId, access: BusAccess, defect: Option<Defect>) -> Self {
        let mut slave = Slave::of(id, access, defect, PARAMETERS.bdefault, Retained::default());
        slave.node.retained = after_power_on(id);
        slave
    }

    fn of(id: NodeId, access: BusAccess, defect: Option<Defect>, stored: Bus, retained: Retained) -> Self {
        let mut redundancy = SlaveRedundancy::new(access, PARAMETERS, Retained::default(), GRACE);
        let stored_parameters = Parameters { bdefault: stored, ..defect::parameters(defect) };
        redundancy.restart(access, stored_parameters, retained);
        let node = Node {
            control: NodeControl::new(id, PARAMETERS.producer, Duration::ZERO, false),
            outgoing: Outgoing::default(),
            received: PerBus::default(),
            bdefault: redundancy.selected(),
            stored,
            retained: retained.encode(),
            waits_for_reset: false,
            silence: None,
            is_warning: false,
            has_given_up: false,
            has_wrong_bdefault: false,
            reports: None,
        };
        Slave { id, access, defect, redundancy, node }
    }

    /// Returns this slave before a restart, with its retained data.
    fn restarted(&self, retained: Retained) -> Slave {
        let mut slave = Slave::of(self.id, self.access, self.defect, self.node.stored, retained);
        slave.node.has_wrong_bdefault = self.node.has_wrong_bdefault;
        slave.node.reports = self.node.reports.as_ref().map(|reports| Reports::new(self.id, reports.what));
        slave
    }

    /// Returns this slave before power-on, with a reporting application.
    pub fn reporting(mut self, what: What) -> Slave {
        self.node.reports = Some(Reports::new(self.id, what));
        self
    }

    /// Returns its access to the buses.
    pub fn access(&self) -> BusAccess {
        self.access
    }

    /// Returns the parameters with the present Bdefault and Ctoggle.
    pub fn parameters(&self) -> &Parameters {
        self.redundancy.parameters()
    }

    /// Returns whether it gave up its search and stays on its bus.
    pub fn has_given_up(&self) -> bool {
        self.node.has_given_up
    }

    /// Returns whether Bdefault changed without a reason in the standard.
    pub fn has_wrong_bdefault(&self) -> bool {
        self.node.has_wrong_bdefault
    }

    /// Lets the redundancy decide, and carries out its decision.
    fn decide<R>(
        &mut self,
        now: Instant,
        decide: impl FnOnce(&mut SlaveRedundancy, &mut SlaveStep) -> R,
    ) -> R {
        let mut actions = SlaveActions::new();
        let mut step = SlaveStep::new(now, &self.node.control, self.node.received, &mut actions);
        let result = decide(&mut self.redundancy, &mut step);
        let mut reported = None;
        for action in actions {
            self.carry_out(action, &mut reported, now);
        }
        self.end_step(now);
        result
    }

    fn end_step(&mut self, now: Instant) {
        if std::mem::take(&mut self.node.is_warning) {
            let emcy = Frame::of(CobId::emcy(self.id), ErrorCode::HEARTBEAT.get().to_le_bytes());
            self.node.outgoing.send(self.active(), emcy, now);
        }
        if self.node.waits_for_reset {
            self.start(now);
        }
    }
}

/// Returns the words that a slave finds at power-on in its memory for Bdefault and resets in a row: they differ, or
/// lack their mark.
fn after_power_on(id: NodeId) -> [u32; 2] {
    let bdefault = Some(PARAMETERS.bdefault.other());
    let [word, check] = Retained { bdefault, resets: 1, ..Retained::default() }.encode();
    if id == PARALLEL { [word, 0] } else { [word & 0xFF_FFFF, check | 0xFF00_0000] }
}

impl Canonical for Slave {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        // The redundancy keeps what it needs of the numbers, so they restart.
        self.redundancy.canonical(now, &std::mem::take(&mut self.node.received));
        self.node.control.canonical(now, &());
        self.node.outgoing.canonical(now, &());
        self.node.silence.due(now);
        self.node.reports.canonical(now, &());
    }
}

impl Station for Slave {
    fn start(&mut self, now: Instant) {
        *self = self.restarted(Retained::decode(self.node.retained).unwrap_or_default());
        self.boot(now);
        self.end_step(now);
    }

    fn power_off(&mut self) {
        *self = self.restarted(Retained::default());
        self.node.retained = after_power_on(self.id);
    }

    fn poll(&mut self, now: Instant) {
        while self.decide(now, |redundancy, step| redundancy.poll(now, step)) {}
        self.resume(now);
        if let Some(heartbeat) = self.node.control.poll(now) {
            self.node.outgoing.send(self.active(), heartbeat, now);
        }
        self.send_reports(now);
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        let question = CobId::sdo_request(self.id);
        let heartbeats = [NodeId::MASTER, self.id].map(CobId::heartbeat);
        if ![CobId::NMT, CobId::SYNC, question].contains(&frame.id()) && !heartbeats.contains(&frame.id()) {
            return;
        }
        self.poll(now);
        self.node.received[bus] += 1;
        if frame.id() == question && bus == self.active() && self.state().allows_sdo() {
            self.node.outgoing.send(bus, self.answer(frame), now);
        } else {
            let verdict = self.redundancy.on_usual_frame(bus, frame, now, &self.node.control);
            let verdict = verdict.unwrap_or_else(|| {
                self.decide(now, |redundancy, step| redundancy.on_rare_frame(bus, frame, now, step))
            });
            let is_heartbeat = frame.id() == CobId::heartbeat(NodeId::MASTER);
            let is_heard = is_heartbeat && bus == self.active();
            assert_eq!(verdict == SlaveVerdict::Heard, is_heard, "{frame:?} on {bus:?}");
            if is_heard {
                self.hear_master(frame.bits() == 0, now);
            }
        }
        self.poll(now);
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.node.outgoing.acknowledge(bus, frame);
        self.node.control.on_sent(frame);
        self.redundancy.on_sent(frame, now, self.id);
        self.report_ended(bus, frame, true, now);
        self.poll(now);
    }

    fn on_expired(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.redundancy.on_end(frame);
        self.report_ended(bus, frame, false, now);
        self.poll(now);
    }

    fn on_overrun(&mut self, bus: Bus, now: Instant) {
        self.announce_after_overrun(bus, now);
        self.poll(now);
    }

    fn on_unacknowledged(&mut self, _bus: Bus, _unacknowledged: bool, _now: Instant) {}

    fn deadline(&self) -> Option<Instant> {
        let node = &self.node;
        earliest(&[
            self.redundancy.deadline(),
            node.control.deadline(),
            node.outgoing.deadline(),
            node.silence,
            self.reports_deadline(),
        ])
    }

    fn is_joined(&self, bus: Bus) -> bool {
        self.redundancy.is_joined(bus)
    }

    fn is_silent(&self) -> bool {
        false
    }

    fn active(&self) -> Bus {
        self.redundancy.selected()
    }

    fn state(&self) -> NmtState {
        self.node.control.state()
    }

    fn outgoing(&mut self) -> &mut Outgoing {
        &mut self.node.outgoing
    }

    fn waiting(&self) -> &Outgoing {
        &self.node.outgoing
    }
}
