//! Inputs of a master that its log alone shows: states of its controllers, and nodes that did not answer.

use ecss_can::link::port::{ErrorState, Health, LastError};
use ecss_can::types::{Bus, Instant, NodeId};

use super::Master;

const STATES: [ErrorState; 3] = [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff];
const ERRORS: [LastError; 7] = [
    LastError::None,
    LastError::Stuff,
    LastError::Form,
    LastError::Ack,
    LastError::BitRecessive,
    LastError::BitDominant,
    LastError::Crc,
];

impl Master {
    /// Takes "Nominal: error Passive, TEC 128, REC 0, last Ack" and "Nominal failed: bus-off too often".
    pub(super) fn on_health_line(&mut self, line: &str, now: Instant) {
        for bus in Bus::ALL {
            let Some(rest) = line.strip_prefix(&format!("{bus:?}")) else { continue };
            if rest.starts_with(" failed") {
                self.failed[bus] = true;
            } else if let Some(health) = rest.strip_prefix(": error ").and_then(health) {
                self.health[bus] = health;
                self.failed[bus] &= health.state == ErrorState::BusOff;
            } else {
                continue;
            }
            if self.redundancy.is_active() {
                self.report_health(bus, now);
            }
        }
    }

    pub(super) fn report_health(&mut self, bus: Bus, now: Instant) {
        self.redundancy.on_health(bus, self.health[bus], self.failed[bus], now);
    }

    /// Takes "node 9 does not answer: it does not count as a slave".
    pub(super) fn on_silent_node(&mut self, line: &str, now: Instant) {
        let number = line.strip_prefix("node ").and_then(|rest| rest.split_once(" does not answer"));
        if let Some(node) = number.and_then(|(number, _)| NodeId::new(number.parse().ok()?)) {
            self.on_no_answer(node, now);
        }
    }
}

/// Reads "Passive, TEC 128, REC 0, last Ack".
fn health(text: &str) -> Option<Health> {
    let mut parts = text.split(", ");
    let state = named(&STATES, parts.next()?)?;
    let tec = parts.next()?.strip_prefix("TEC ")?.parse().ok()?;
    let rec = parts.next()?.strip_prefix("REC ")?.parse().ok()?;
    let last_error = named(&ERRORS, parts.next()?.strip_prefix("last ")?)?;
    Some(Health { state, tec, rec, last_error })
}

fn named<T: Copy + std::fmt::Debug>(all: &[T], name: &str) -> Option<T> {
    all.iter().copied().find(|value| format!("{value:?}") == name)
}
