//! What a board did in flight, by its record.

use can_wire::time::Time;
use ecss_can::emcy::ErrorCode;
use ecss_can::heartbeat;
use ecss_can::types::{Bus, CobId, Frame, NmtState, NodeId};
use twin::bxcan::Exchange;

use crate::machine::Machine;
use crate::mailboxes::Mailboxes;
use crate::output::Output;
use crate::recording::{BoardRecord, What};
use crate::run::{STARTS, frame};
use crate::slave::RESET;

const STATES: [NmtState; 4] =
    [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational];

/// Outputs of a board in flight.
#[derive(Debug, Default)]
pub struct Flown {
    /// Outputs, in the order of time.
    pub outputs: Vec<(Time, Output)>,
    /// Instants of all EMCYs.
    pub emergencies: Vec<Time>,
    /// Changes of the active bus, in the order of time.
    pub buses: Vec<(Time, Bus)>,
    /// Changes of the NMT state, in the order of time.
    pub states: Vec<(Time, NmtState)>,
    /// Instants at which the chip was reset, or lost or got its power, and the end of the run.
    pub ends: Vec<Time>,
    /// Mailboxes of both controllers.
    pub mailboxes: Mailboxes,
}

impl Flown {
    /// Reads a record. `end`: end of the run.
    pub fn read(record: &BoardRecord, own: NodeId, machine: &dyn Machine, end: Time) -> Flown {
        let mut flown = Flown::default();
        for entry in &record.entries {
            match &entry.what {
                What::Line(line) => flown.read_line(entry.at, line, machine),
                What::Exchange(bus, exchange) => flown.read_exchange(entry.at, *bus, exchange, own),
            }
        }
        flown.end(end);
        flown
    }

    fn end(&mut self, at: Time) {
        self.ends.push(at);
        self.mailboxes.reset(at);
    }

    fn read_exchange(&mut self, at: Time, bus: Bus, exchange: &Exchange, own: NodeId) {
        match exchange {
            Exchange::Reset | Exchange::Power => self.end(at),
            Exchange::Requested(wire) => {
                let Some(frame) = frame(wire) else { return };
                if self.mailboxes.request(at, bus, frame) {
                    self.read_frame(at, bus, frame, own);
                }
            }
            Exchange::Sent(wire) | Exchange::Aborted(wire) => {
                let Some(frame) = frame(wire) else { return };
                self.mailboxes.end(at, bus, &frame, matches!(exchange, Exchange::Aborted(_)));
            }
            Exchange::Taken(_) | Exchange::Errors(_) => {}
        }
    }

    fn read_frame(&mut self, at: Time, bus: Bus, frame: Frame, own: NodeId) {
        if frame == heartbeat::encode(own, NmtState::Initialising) {
            self.buses.push((at, bus));
        }
        if frame.id() != CobId::emcy(own) {
            self.outputs.push((at, Output::Frame(bus, frame)));
            return;
        }
        self.emergencies.push(at);
        if let &[low, high, _, source, ..] = frame.data() {
            let code = u16::from_le_bytes([low, high]);
            // Missed slaves are reported by the consumers of 1016h, not by the redundancy.
            let is_of_master = code == ErrorCode::HEARTBEAT.get() && source == NodeId::MASTER.get();
            if is_of_master || code == ErrorCode::CAN_ID_COLLISION.get() {
                self.outputs.push((at, Output::Emergency(code, source)));
            }
        }
    }

    fn read_line(&mut self, at: Time, line: &str, machine: &dyn Machine) {
        if line.contains(STARTS) || line == RESET {
            self.states.push((at, NmtState::Initialising));
        }
        if !machine.is_of_machine(line) {
            return;
        }
        self.outputs.push((at, Output::Line(line.into())));
        let state = STATES.into_iter().find(|state| format!("{state:?}") == line);
        self.states.extend(state.map(|state| (at, state)));
        let rest =
            line.strip_prefix("active bus: ").or_else(|| line.strip_prefix("this master board: Active on "));
        let named = |bus: &Bus| rest.is_some_and(|rest| rest.starts_with(&format!("{bus:?}")));
        let bus = Bus::ALL.into_iter().find(named);
        self.buses.extend(bus.map(|bus| (at, bus)));
    }
}
