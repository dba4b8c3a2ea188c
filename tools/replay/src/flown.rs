//! What a board did in flight, by its record.

use std::collections::VecDeque;

use can_wire::time::Time;
use ecss_can::emcy::ErrorCode;
use ecss_can::heartbeat;
use ecss_can::types::{Bus, CobId, Frame, NmtState, NodeId, PerBus};
use twin::bxcan::Exchange;

use crate::machine::Machine;
use crate::output::Output;
use crate::recording::{BoardRecord, What};
use crate::run::{STARTS, frame};

/// A frame that was aborted for an urgent one is requested again within its lifetime, 100 ms. A request at the end of the
/// lifetime is that of the next frame.
const RETURN: Time = Time::from_us(99_500);
const STATES: [NmtState; 4] =
    [NmtState::Initialising, NmtState::Stopped, NmtState::Operational, NmtState::PreOperational];
/// Mailboxes that a frame without urgency may have: one of three is kept free.
const MAILBOXES: usize = 2;

/// Outputs of a board in flight.
#[derive(Debug, Default)]
pub struct Flown {
    /// Outputs, in the order of time.
    pub outputs: Vec<(Time, Output)>,
    /// Changes of the active bus, in the order of time.
    pub buses: Vec<(Time, Bus)>,
    /// Changes of the NMT state, in the order of time.
    pub states: Vec<(Time, NmtState)>,
    /// Instants at which the chip was reset, or lost or got its power, and the end of the record.
    pub ends: Vec<Time>,
    /// From when to when frames had to wait for a mailbox of each bus.
    pub full: PerBus<Vec<(Time, Time)>>,
}

impl Flown {
    /// Reads a record. `end`: end of the run.
    pub fn read(record: &BoardRecord, own: NodeId, machine: &dyn Machine, end: Time) -> Flown {
        let mut flown = Flown::default();
        let boot_up = heartbeat::encode(own, NmtState::Initialising);
        let mut pending: PerBus<VecDeque<(Time, Frame)>> = PerBus::default();
        let mut aborted: Vec<(Time, Bus, Frame)> = Vec::new();
        let mut full: PerBus<Option<Time>> = PerBus::default();
        for entry in &record.entries {
            let at = entry.at;
            match &entry.what {
                What::Line(line) => flown.read_line(at, line, machine),
                What::Exchange(_, Exchange::Reset | Exchange::Power) => {
                    flown.ends.push(at);
                    (pending, aborted) = Default::default();
                }
                What::Exchange(bus, Exchange::Requested(wire)) => {
                    let Some(frame) = frame(wire) else { continue };
                    let again = aborted.iter().position(|(_, on, one)| (on, one) == (bus, &frame));
                    let first = match again.map(|place| aborted.remove(place)) {
                        Some((first, ..)) if at < first + RETURN => first,
                        _ => {
                            if frame == boot_up {
                                flown.buses.push((at, *bus));
                            }
                            flown.outputs.extend(output(*bus, &frame, own).map(|output| (at, output)));
                            at
                        }
                    };
                    pending[*bus].push_back((first, frame));
                }
                What::Exchange(bus, Exchange::Sent(wire) | Exchange::Aborted(wire)) => {
                    let Some(frame) = frame(wire) else { continue };
                    let place = pending[*bus].iter().position(|(_, one)| *one == frame);
                    let ended = place.and_then(|place| pending[*bus].remove(place));
                    if let (Some((first, frame)), What::Exchange(_, Exchange::Aborted(_))) = (ended, &entry.what) {
                        aborted.push((first, *bus, frame));
                    }
                }
                What::Exchange(_, Exchange::Taken(_)) => {}
            }
            for bus in Bus::ALL {
                let is_full = pending[bus].len() >= MAILBOXES;
                match (is_full, full[bus]) {
                    (true, None) => full[bus] = Some(at),
                    (false, Some(since)) => {
                        flown.full[bus].push((since, at));
                        full[bus] = None;
                    }
                    _ => {}
                }
            }
        }
        for bus in Bus::ALL {
            flown.full[bus].extend(full[bus].map(|since| (since, end)));
        }
        flown.ends.push(end);
        flown
    }

    fn read_line(&mut self, at: Time, line: &str, machine: &dyn Machine) {
        if line.contains(STARTS) {
            self.states.push((at, NmtState::Initialising));
        }
        if !machine.is_of_machine(line) {
            return;
        }
        self.outputs.push((at, Output::Line(line.into())));
        let state = STATES.into_iter().find(|state| format!("{state:?}") == *line);
        self.states.extend(state.map(|state| (at, state)));
        let rest = line.strip_prefix("active bus: ").or_else(|| line.strip_prefix("this master board: Active on "));
        let bus = rest.and_then(|rest| Bus::ALL.into_iter().find(|bus| rest.starts_with(&format!("{bus:?}"))));
        self.buses.extend(bus.map(|bus| (at, bus)));
    }

    /// Returns whether a frame had to wait for a mailbox between these instants.
    pub fn is_full(&self, bus: Bus, from: Time, to: Time) -> bool {
        self.full[bus].iter().any(|(since, until)| *since <= to && *until >= from)
    }
}

fn output(bus: Bus, frame: &Frame, own: NodeId) -> Option<Output> {
    if frame.id() != CobId::emcy(own) {
        return Some(Output::Frame(bus, *frame));
    }
    let &[low, high, _, source, ..] = frame.data() else { return None };
    let code = u16::from_le_bytes([low, high]);
    // Missed slaves are reported by the consumers of 1016h, not by the redundancy.
    let is_missed = code == ErrorCode::HEARTBEAT.get() && source == NodeId::MASTER.get();
    (is_missed || code == ErrorCode::CAN_ID_COLLISION.get()).then_some(Output::Emergency(code, source))
}
