//! A slave of the model: its redundancy as it flies, on the wires of the model.

use ecss_can::emcy::ErrorCode;
use ecss_can::heartbeat::NodeControl;
use ecss_can::redundancy::{
    Broken, BusAccess, BusCause, Parameters, Retained, SlaveAction, SlaveNode, SlaveRedundancy,
};
use ecss_can::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus, Rebase, earliest};
use judge::selector::is_bdefault_right;

use crate::profile::{GRACE, PARAMETERS};
use crate::station::{Outgoing, Station};

/// A slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Slave {
    redundancy: SlaveRedundancy,
    node: Node,
}

/// The node around the redundancy.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Node {
    access: BusAccess,
    broken: Option<Broken>,
    control: NodeControl,
    outgoing: Outgoing,
    /// Frames that passed its filters.
    received: PerBus<u32>,
    /// Bdefault in the dictionary, and in the parameter store.
    bdefault: [Bus; 2],
    /// Memory that outlives a reset.
    retained: Retained,
    waits_for_reset: bool,
    has_given_up: bool,
    has_wrong_bdefault: bool,
}

/// The node in one step.
struct Acting<'a> {
    node: &'a mut Node,
    now: Instant,
    cause: Option<(BusCause, Bus)>,
}

impl Slave {
    /// A slave before power-on. `broken`: a rule that does not hold.
    pub fn new(id: NodeId, access: BusAccess, broken: Option<Broken>) -> Self {
        let mut redundancy = SlaveRedundancy::new(access, PARAMETERS, Retained::default(), GRACE);
        redundancy.break_rule(broken);
        let node = Node {
            access,
            broken,
            control: NodeControl::new(id, PARAMETERS.producer, Duration::ZERO, false),
            outgoing: Outgoing::default(),
            received: PerBus::default(),
            bdefault: [PARAMETERS.bdefault; 2],
            retained: Retained::default(),
            waits_for_reset: false,
            has_given_up: false,
            has_wrong_bdefault: false,
        };
        Slave { redundancy, node }
    }

    /// How it accesses its buses.
    pub fn access(&self) -> BusAccess {
        self.node.access
    }

    /// The parameters with the present Bdefault and Ctoggle.
    pub fn parameters(&self) -> &Parameters {
        self.redundancy.parameters()
    }

    /// It gave up its search and stays where it is.
    pub fn has_given_up(&self) -> bool {
        self.node.has_given_up
    }

    /// Bdefault changed for no reason that the standard knows.
    pub fn has_wrong_bdefault(&self) -> bool {
        self.node.has_wrong_bdefault
    }

    /// Shifts the clock.
    pub fn rebase(&mut self, now: Instant) {
        let to = Rebase::new(now);
        self.node.received = self.redundancy.rebase(self.node.received, now);
        self.node.control.rebase(&to);
        self.node.outgoing.rebase(&to);
    }

    fn step<R>(&mut self, now: Instant, step: impl FnOnce(&mut SlaveRedundancy, &mut Acting) -> R) -> R {
        let result = step(&mut self.redundancy, &mut Acting { node: &mut self.node, now, cause: None });
        if self.node.waits_for_reset {
            self.start(now);
        }
        result
    }
}

impl SlaveNode for Acting<'_> {
    fn control(&mut self) -> &mut NodeControl {
        &mut self.node.control
    }

    fn received(&self) -> PerBus<u32> {
        self.node.received
    }

    fn restore_communication(&mut self) -> Parameters {
        Parameters { bdefault: self.node.bdefault[0], ..PARAMETERS }
    }

    fn show(&mut self, parameters: &Parameters) {
        let before = std::mem::replace(&mut self.node.bdefault[0], parameters.bdefault);
        let is_right = is_bdefault_right(before, parameters.bdefault, self.cause.take());
        self.node.has_wrong_bdefault |= !is_right;
    }

    fn note_bdefault(&mut self, bus: Bus) -> Option<bool> {
        self.node.bdefault[1] = bus;
        Some(true)
    }

    fn act(&mut self, action: SlaveAction) {
        let (node, now) = (&mut *self.node, self.now);
        match action {
            SlaveAction::BootUp { bus } => {
                node.outgoing.send(bus, node.control.boot(now), now);
                node.has_given_up = false;
            }
            SlaveAction::ActiveBus { bus, cause, is_new } => {
                self.cause = Some((cause, bus));
                if is_new {
                    node.outgoing.abandon(bus.other());
                }
            }
            SlaveAction::GaveUp { .. } => node.has_given_up = true,
            SlaveAction::MasterMissed { .. } | SlaveAction::Clear { code: ErrorCode::HEARTBEAT, .. } => {
                node.has_given_up = false;
            }
            SlaveAction::ResetNode => node.waits_for_reset = true,
            SlaveAction::Retain(retained) => node.retained = retained,
            _ => {}
        }
    }
}

impl Station for Slave {
    fn start(&mut self, now: Instant) {
        let node = &self.node;
        let (retained, bdefault) = (node.retained, node.bdefault[1]);
        let mut started = Slave::new(node.control.id(), node.access, node.broken);
        let stored = Parameters { bdefault, ..PARAMETERS };
        started.redundancy = SlaveRedundancy::new(node.access, stored, retained, GRACE);
        started.redundancy.break_rule(node.broken);
        started.node.bdefault = [started.parameters().bdefault, bdefault];
        (started.node.retained, started.node.has_wrong_bdefault) = (retained, node.has_wrong_bdefault);
        *self = started;
        self.step(now, |redundancy, node| redundancy.boot(now, node));
    }

    fn power_off(&mut self) {
        let stored = self.node.bdefault[1];
        *self = Slave::new(self.node.control.id(), self.node.access, self.node.broken);
        self.node.bdefault[1] = stored;
    }

    fn poll(&mut self, now: Instant) {
        self.step(now, |redundancy, node| redundancy.poll(now, now, node));
        if let Some(heartbeat) = self.node.control.poll(now) {
            self.node.outgoing.send(self.active(), heartbeat, now);
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.poll(now);
        let (id, own) = (frame.id(), self.node.control.id());
        let is_question = id == CobId::sdo_request(own);
        if !is_question && id != CobId::SYNC && id != CobId::NMT && id != CobId::heartbeat(NodeId::MASTER) {
            return;
        }
        self.node.received[bus] += 1;
        if is_question && bus == self.active() && self.state().allows_sdo() {
            self.node.outgoing.send(bus, Frame::of(CobId::sdo_response(own), []), now);
        } else {
            self.step(now, |redundancy, node| redundancy.on_frame(bus, frame, now, now, node));
        }
        self.poll(now);
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.node.outgoing.acknowledge(bus, frame);
        self.node.control.on_sent(frame);
        if self.redundancy.on_sent(frame, now, self.node.control.id()) {
            self.poll(now);
        }
    }

    fn on_expired(&mut self, _bus: Bus, frame: &Frame, now: Instant) {
        if self.redundancy.on_end(frame) {
            self.poll(now);
        }
    }

    fn on_unacknowledged(&mut self, _bus: Bus, _unacknowledged: bool, _now: Instant) {}

    fn deadline(&self) -> Option<Instant> {
        let node = &self.node;
        earliest(&[self.redundancy.deadline(), node.control.deadline(), node.outgoing.deadline()])
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
