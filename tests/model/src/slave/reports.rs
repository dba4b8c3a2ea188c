//! Reports of a slave's application: one error by the producer of the firmware, and one value.

use ecss_can::emcy::machine::{Config, Producer};
use ecss_can::types::{
    Address, Bus, Canonical, CobId, Duration, Frame, Instant, Instants as _, NmtState, NodeId, earliest,
};

use super::Slave;
use crate::defect::Defect;
use crate::station::Station;
use crate::what::{ERROR, SOURCE, What, value_id};

/// Time from an unsent frame of the value to the next one.
const RETRY: Duration = Duration::from_millis(50);

/// Time from an overrun to the announcement. A receiver that is too slow loses many frames.
const AFTER_OVERRUN: Duration = Duration::from_millis(1_000);

/// Error and value of a slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Reports {
    /// Whether it is the error or the value.
    pub what: What,
    emcy: Producer,
    /// Whether the error is active.
    pub is_wrong: bool,
    /// Whether the value has changed. It changes once.
    pub has_changed: bool,
    /// Instant at which the value is sent.
    due: Option<Instant>,
}

impl Reports {
    /// Makes the reports of a slave at power-on.
    pub fn new(id: NodeId, what: What) -> Reports {
        let emcy = Producer::new(Config { id: Some(CobId::emcy(id)), inhibit: Duration::ZERO });
        Reports { what, emcy, is_wrong: false, has_changed: false, due: None }
    }

    /// Handles a change of the NMT state.
    pub fn enter(&mut self, state: NmtState, now: Instant) {
        self.due = self.is_sent(state).then_some(now);
    }

    /// Announces the reports when the slave found or followed the master, or the master booted.
    pub fn announce(&mut self, state: NmtState, now: Instant) {
        self.emcy.on_bus_changed();
        self.send_state(state, now);
    }

    /// Returns whether the value is sent in this state.
    fn is_sent(&self, state: NmtState) -> bool {
        self.what == What::Value && state == NmtState::Operational
    }

    fn send_state(&mut self, state: NmtState, at: Instant) {
        if self.is_sent(state) {
            self.due = earliest(&[self.due, Some(at)]);
        }
    }

    /// Handles a change of the bus.
    pub fn leave(&mut self) {
        self.emcy.recall(Instant::ZERO);
    }

    /// Handles a heartbeat of the master.
    pub fn confirm(&mut self) {
        self.emcy.confirm();
    }

    /// Resets the communication.
    pub fn restart(&mut self) {
        self.emcy.restart();
    }

    /// Returns the value of an object that the master reads.
    fn read(&self, object: Address) -> u32 {
        match object.index {
            0x1001 => self.emcy.register().bits().into(),
            _ if object.sub == 0 => self.emcy.history().len().into(),
            _ => self.emcy.history().read(object.sub).unwrap_or(0),
        }
    }
}

impl Canonical for Reports {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        self.emcy.canonical(now, &());
        self.due.due(now);
    }
}

impl Slave {
    /// Returns the reports of its application, if there are any.
    pub fn reports(&self) -> Option<&Reports> {
        self.node.reports.as_ref()
    }

    /// Starts or ends the error.
    pub fn turn_wrong(&mut self, is_wrong: bool, now: Instant) {
        let Some(reports) = &mut self.node.reports else { return };
        reports.is_wrong = is_wrong;
        if is_wrong {
            reports.emcy.raise(ERROR, [SOURCE, 0, 0, 0, 0]);
        } else {
            reports.emcy.clear(ERROR, SOURCE);
        }
        self.poll(now);
    }

    /// Changes the value.
    pub fn change(&mut self, now: Instant) {
        let is_operational = self.state() == NmtState::Operational;
        let Some(reports) = &mut self.node.reports else { return };
        reports.has_changed = true;
        if is_operational {
            reports.due = Some(now);
        }
        self.poll(now);
    }

    /// Sends the value again when its event timer has expired.
    pub fn repeat_value(&mut self, now: Instant) {
        let state = self.state();
        self.node.reports.iter_mut().for_each(|reports| reports.send_state(state, now));
    }

    /// Sends what is due.
    pub(super) fn send_reports(&mut self, now: Instant) {
        let (id, bus, state) = (self.id, self.active(), self.node.control.reporting_state());
        let Some(reports) = &mut self.node.reports else { return };
        while let Some(frame) = reports.emcy.poll(now, state) {
            self.node.outgoing.send(bus, frame, now);
        }
        if reports.due.take_if(|due| *due <= now).is_some() {
            let frame = Frame::of(value_id(id), [u8::from(reports.has_changed)]);
            self.node.outgoing.send(bus, frame, now);
        }
    }

    /// Returns the deadline of the reports.
    pub(super) fn reports_deadline(&self) -> Option<Instant> {
        let reports = self.node.reports.as_ref()?;
        earliest(&[reports.emcy.deadline(self.node.control.reporting_state()), reports.due])
    }

    /// Handles a frame that was acknowledged or has expired.
    pub(super) fn report_ended(&mut self, bus: Bus, frame: &Frame, is_acknowledged: bool, now: Instant) {
        if bus != self.active() {
            return;
        }
        let is_value = frame.id() == value_id(self.id) && self.state() == NmtState::Operational;
        let Some(reports) = &mut self.node.reports else { return };
        reports.emcy.on_end(frame, is_acknowledged, now);
        if is_value && !is_acknowledged {
            reports.due = earliest(&[reports.due, Some(now + RETRY)]);
        }
    }

    /// Handles a heartbeat or boot-up message of the master on the active bus.
    pub(super) fn hear_master(&mut self, is_boot_up: bool, now: Instant) {
        let (state, is_announced) = (self.state(), self.defect != Some(Defect::NeverAnnounces));
        match &mut self.node.reports {
            Some(reports) if is_boot_up && is_announced => reports.announce(state, now),
            Some(reports) if !is_boot_up => reports.confirm(),
            _ => {}
        }
    }

    /// Announces the reports after an overrun, because the lost frame may have been the boot-up message of the master.
    pub(super) fn announce_after_overrun(&mut self, bus: Bus, now: Instant) {
        let (state, is_here) = (self.state(), bus == self.active());
        if let Some(reports) = self.node.reports.as_mut().filter(|_| is_here) {
            reports.send_state(state, now + AFTER_OVERRUN);
        }
    }

    /// Returns the answer to a question of the master. An identification has no data.
    pub(super) fn answer(&self, question: &Frame) -> Frame {
        let id = CobId::sdo_response(self.id);
        match (question.data(), &self.node.reports) {
            (&[low, high, sub], Some(reports)) => {
                let object = Address::new(u16::from_le_bytes([low, high]), sub);
                Frame::of(id, reports.read(object).to_le_bytes())
            }
            _ => Frame::of(id, []),
        }
    }
}
