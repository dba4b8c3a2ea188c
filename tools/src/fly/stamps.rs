//! Compares the boards' stamps of SYNC with the true ends of its frames.
//!
//! The true end is that of the frame at its transmitter plus the delay of the cable, on the board's own capture timer.
//! A board keeps its last stamp only, and SYNCs are far apart: one read after each is enough.

use can_twin::spacecraft::{BoardId, Bus, Spacecraft, WireRecord};
use can_twin::wire::frame::WireId;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

use crate::images::support::diagnostics::Diagnostics;

const SYNC: WireId = WireId::Standard(0x080);

/// Time after which all tasks have handled a frame.
const DEALT_WITH: Time = Time::from_ms(2);

/// Ticks of the capture timer per nanosecond.
const TICKS_PER_NS: f64 = 0.084;

/// Errors of stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StampErrors {
    /// Stamps compared, all boards.
    pub compared: u64,
    /// Largest error, ns.
    pub worst_ns: f64,
    /// Sum of the squares of all errors, ns².
    pub squares_ns2: f64,
}

impl StampErrors {
    /// Root of the mean square, ns.
    pub fn rms_ns(&self) -> f64 {
        (self.squares_ns2 / self.compared.max(1) as f64).sqrt()
    }

    /// Combines the errors of two flights.
    #[must_use]
    pub fn and(&self, other: &StampErrors) -> StampErrors {
        StampErrors {
            compared: self.compared + other.compared,
            worst_ns: self.worst_ns.max(other.worst_ns),
            squares_ns2: self.squares_ns2 + other.squares_ns2,
        }
    }
}

/// Compares stamps during the flight.
#[derive(Debug, Default)]
pub struct StampWatch {
    /// SYNCs not compared yet: bus, end at the transmitter, sender and receivers.
    pending: Vec<(Bus, Time, usize, Vec<usize>)>,
    /// Number of stamps that each board had captured at the last read.
    captured: Vec<u32>,
    errors: StampErrors,
}

impl StampWatch {
    /// Handles a completed frame.
    pub fn on(&mut self, wire: &WireRecord) {
        if let Observation::Completed { trace, receivers, .. } = &wire.record
            && trace.frame.id == SYNC
        {
            let receivers = receivers.iter().map(|&(node, _)| node).collect();
            self.pending.push((wire.bus, trace.end, trace.transmitter, receivers));
        }
    }

    /// Reads the boards some time after a SYNC.
    pub fn look(&mut self, spacecraft: &Spacecraft) {
        let due =
            |&mut (_, end, ..): &mut (Bus, Time, usize, Vec<usize>)| end + DEALT_WITH <= spacecraft.now();
        let synced: Vec<_> = self.pending.extract_if(.., due).collect();
        let boards = spacecraft.boards().count();
        self.captured.resize(boards, 0);
        for (bus, end, transmitter, receivers) in synced {
            for node in receivers.into_iter().chain([transmitter]).filter(|&node| node < boards) {
                let board = spacecraft.board(BoardId(node));
                let Ok(Diagnostics { stamps, .. }) = Diagnostics::read(board) else { continue };
                // A reset restarts the count.
                if stamps.captured == std::mem::replace(&mut self.captured[node], stamps.captured) {
                    continue;
                }
                let truth = board.capture_clock(end + spacecraft.wire(bus).delay(transmitter, node));
                let distance = (f64::from(stamps.last) - truth).rem_euclid(2_f64.powi(32));
                let error = distance.min(2_f64.powi(32) - distance) / TICKS_PER_NS;
                self.errors.compared += 1;
                self.errors.worst_ns = self.errors.worst_ns.max(error);
                self.errors.squares_ns2 += error * error;
            }
        }
    }

    /// Returns the errors.
    pub fn errors(&self) -> StampErrors {
        self.errors
    }
}
