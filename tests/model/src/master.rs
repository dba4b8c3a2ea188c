//! The master of the model: the redundancy of the firmware on the wires of the model.

mod adapter;
mod application;
mod boot;
pub mod errors;

use ecss_can::link::machine;
use ecss_can::redundancy::machine::{MasterRedundancy, MasterSetup};
use ecss_can::redundancy::{RoleCause, RoleChange, Strap, SwitchCause, TwoBoards};
use ecss_can::types::{
    Bus, Canonical, CobId, Frame, Instant, Instants as _, NmtState, NodeId, PerBus, Periodic, earliest,
};

use self::boot::BootProcess;
use self::errors::Known;
use crate::defect::Defect;
use crate::profile::{
    HELD, MASTER_PARAMETERS, MASTER_SETUP, MINORITY_SHARE, PAIR, PARALLEL, PARAMETERS, PLACES, SELECTIVE,
    SILENT_SHARE,
};
use crate::station::{Outgoing, Station};
use crate::what::What;

/// A master.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Master {
    /// Decides its bus, its role and its frames.
    pub redundancy: MasterRedundancy<TwoBoards, PLACES, HELD>,
    strap: Option<Strap>,
    is_assigned: bool,
    has_boot: bool,
    boot: BootProcess,
    sync: Periodic,
    outgoing: Outgoing,
    unacknowledged: PerBus<bool>,
    /// Whether a heartbeat or boot-up message was sent on the active bus, or expired.
    is_announced: bool,
    /// Buses that failed because its controller was bus-off too often.
    failed: PerBus<bool>,
    /// Slave that the application stopped, and the instant at which it starts it again.
    held: Option<(Instant, NodeId)>,
    /// Its knowledge of the reporting slave.
    known: Option<Known>,
    /// Reason for a change of the bus in this step.
    pub switched: Option<SwitchCause>,
    /// Change of its role in this step.
    pub role_changed: Option<RoleChange>,
}

impl Master {
    /// Makes a master before power-on, one of two if it has a strap. `is_assigned`: it has both slaves in its list.
    /// `has_boot`: it checks slaves before it starts them. Without a list, one silent slave of two is a minority.
    pub fn new(strap: Option<Strap>, is_assigned: bool, has_boot: bool) -> Self {
        let boards = TwoBoards::new(strap.map(|_| PAIR), strap.unwrap_or(Strap::Prime));
        let silent_share = if is_assigned { SILENT_SHARE } else { MINORITY_SHARE };
        let redundancy = MasterRedundancy::new(boards, &MasterSetup { silent_share, ..MASTER_SETUP });
        Master {
            redundancy,
            strap,
            is_assigned,
            has_boot,
            boot: BootProcess::new(has_boot),
            sync: Periodic::new(PARAMETERS.producer),
            outgoing: Outgoing::default(),
            unacknowledged: PerBus::default(),
            is_announced: false,
            failed: PerBus::default(),
            held: None,
            known: None,
            switched: None,
            role_changed: None,
        }
    }

    /// Returns this master before power-on with one reporting slave.
    pub fn alone_with(mut self, node: NodeId, what: What, defect: Option<Defect>) -> Master {
        self.known = Some(Known::new(node, what, defect));
        self
    }

    /// Returns whether it manages the network.
    pub fn is_active(&self) -> bool {
        self.redundancy.is_active()
    }

    /// Handles a controller that was bus-off too often, or is on the bus again. `is_powered`: it notices that at once.
    pub fn on_bus_off(&mut self, bus: Bus, is_failed: bool, is_powered: bool, now: Instant) {
        self.failed[bus] = is_failed;
        if is_powered {
            self.report_health(bus, now);
            self.poll(now);
        }
    }

    fn change_role(&mut self, change: RoleChange, was_active: bool) {
        let gives_up = matches!(change.cause, RoleCause::Yielded | RoleCause::Commanded);
        assert_eq!(gives_up, was_active, "{change:?}");
        self.role_changed = Some(change);
    }

    /// Clears the changes of this step.
    pub fn forget_news(&mut self) {
        (self.switched, self.role_changed) = (None, None);
    }

    fn boot_up(&mut self, now: Instant) {
        let (machine::Outgoing { frame, expires }, _) = self.redundancy.boot_up(now);
        self.is_announced = false;
        self.outgoing.send_until(self.active(), frame, expires);
        self.sync.restart(now);
    }

    /// Identifies new nodes. A slave answers at the same time, or its question is repeated at the next one.
    fn identify(&mut self, now: Instant) {
        while let Some(node) = self.redundancy.peers_mut().take_unasked() {
            self.outgoing.send(self.active(), Frame::of(CobId::sdo_request(node), []), now);
        }
    }
}

fn is_heartbeat(frame: &Frame) -> bool {
    frame.id() == CobId::heartbeat(NodeId::MASTER)
}

impl Canonical for Master {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        self.redundancy.canonical(now, &());
        self.sync.canonical(now, &());
        self.outgoing.canonical(now, &());
        self.held.iter_mut().for_each(|(end, _)| end.due(now));
        self.known.canonical(now, &());
    }
}

impl Station for Master {
    fn start(&mut self, now: Instant) {
        self.power_off();
        self.redundancy.restore(MASTER_PARAMETERS);
        if self.is_assigned {
            let only = self.known.as_ref().map(Known::node);
            for node in [PARALLEL, SELECTIVE].into_iter().filter(|node| only.is_none_or(|only| only == *node))
            {
                self.redundancy.peers_mut().assign(node, true);
            }
        } else {
            // Slaves are in 1016h, so the master measures no periods. An outage would lengthen a measured period.
            let entry = |node: NodeId| u32::from(node.get()) << 16 | PARAMETERS.consumer.as_millis() as u32;
            self.redundancy.peers_mut().set_times(&[PARALLEL, SELECTIVE].map(entry));
        }
        if self.redundancy.start(now) {
            self.boot_up(now);
            let failed = Bus::ALL.into_iter().filter(|bus| self.failed[*bus]).collect::<Vec<_>>();
            failed.into_iter().for_each(|bus| self.report_health(bus, now));
            self.poll(now);
        }
    }

    fn power_off(&mut self) {
        let (failed, known) = (self.failed, self.known.as_ref().map(Known::restarted));
        *self = Master::new(self.strap, self.is_assigned, self.has_boot);
        (self.failed, self.known) = (failed, known);
    }

    fn poll(&mut self, now: Instant) {
        while let Some(action) = self.redundancy.poll(now, now) {
            self.act(action, now);
            assert!(self.redundancy.has_room(), "few frames wait for a bus at a time");
        }
        self.release(now);
        if self.is_active() && self.redundancy.is_announced() {
            self.identify(now);
            self.read_errors(now);
            if self.sync.due(now) {
                self.outgoing.send(self.active(), Frame::of(CobId::SYNC, []), now);
            }
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.poll(now);
        if self.is_active() {
            let node = frame.id().node().filter(|node| *node != NodeId::MASTER);
            self.redundancy.on_frame(bus, node, now);
        }
        self.take(bus, frame, now);
        self.poll(now);
    }

    fn on_sent(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.outgoing.acknowledge(bus, frame);
        // A claim may still be pending from before the change of the bus.
        if bus == self.active() && PAIR.claim(frame).is_none() {
            self.is_announced |= is_heartbeat(frame);
            assert!(self.is_announced, "{frame:?} before the heartbeat on {bus:?}");
        }
        self.redundancy.on_sent(bus, frame.id(), now);
        self.poll(now);
    }

    fn on_expired(&mut self, bus: Bus, frame: &Frame, now: Instant) {
        self.is_announced |= bus == self.active() && is_heartbeat(frame);
        self.redundancy.on_failed(bus, frame.id());
        if let Some(node) = frame.id().node().filter(|node| frame.id() == CobId::sdo_request(*node)) {
            self.redundancy.peers_mut().ask_again(node);
        }
        self.poll(now);
    }

    fn on_overrun(&mut self, _bus: Bus, now: Instant) {
        self.known.iter_mut().for_each(Known::restart);
        self.poll(now);
    }

    fn on_unacknowledged(&mut self, bus: Bus, unacknowledged: bool, now: Instant) {
        if self.unacknowledged[bus] != unacknowledged {
            self.unacknowledged[bus] = unacknowledged;
            self.report_health(bus, now);
            self.poll(now);
        }
    }

    fn deadline(&self) -> Option<Instant> {
        let due = self.redundancy.deadline();
        if !self.is_active() {
            return due;
        }
        let announced = [self.sync.deadline(), self.errors_deadline()];
        let [sync, errors] = announced.map(|due| due.filter(|_| self.redundancy.is_announced()));
        earliest(&[due, sync, errors, self.outgoing.deadline(), self.held.map(|(end, _)| end)])
    }

    fn is_joined(&self, bus: Bus) -> bool {
        self.redundancy.is_joined(bus)
    }

    fn is_silent(&self) -> bool {
        !self.is_active()
    }

    fn active(&self) -> Bus {
        self.redundancy.active()
    }

    fn state(&self) -> NmtState {
        self.redundancy.state()
    }

    fn outgoing(&mut self) -> &mut Outgoing {
        &mut self.outgoing
    }

    fn waiting(&self) -> &Outgoing {
        &self.outgoing
    }
}
