//! Boards of a spacecraft, as a table.

use std::collections::BTreeMap;
use std::fmt::Write;

use can_wire::frame::WireId;
use can_wire::record::Observation;
use can_wire::time::Time;
use firmware_images::support::node::Node;
use twin::bxcan::Side;
use twin::spacecraft::{BoardId, Bus, Spacecraft, WireRecord};

/// Identifier of the heartbeat of node 0.
const HEARTBEAT: u16 = 0x700;

/// The last heartbeat of each node.
#[derive(Debug, Default)]
pub struct Heartbeats(BTreeMap<Node, Heartbeat>);

#[derive(Clone, Copy, Debug)]
struct Heartbeat {
    at: Time,
    bus: Bus,
    state: u8,
}

impl Heartbeats {
    /// What was on the wires.
    pub fn observe(&mut self, record: &WireRecord) {
        let Observation::Completed { trace, .. } = &record.record else { return };
        let (WireId::Standard(id), [state]) = (trace.frame.id, trace.frame.payload()) else { return };
        if let Some(node) = id.checked_sub(HEARTBEAT).filter(|node| (1..=127).contains(node)) {
            let heartbeat = Heartbeat { at: trace.end, bus: record.bus, state: *state };
            self.0.insert(node as Node, heartbeat);
        }
    }

    /// The table.
    pub fn status(&self, boards: &BTreeMap<Node, BoardId>, spacecraft: &Spacecraft) -> String {
        let mut table = String::from(
            "node  place    power  last heartbeat                      TEC/REC nominal  redundant",
        );
        for (&node, &board) in boards {
            let config = spacecraft.board(board);
            let power = if config.is_powered() { "on" } else { "off" };
            let heartbeat = self.0.get(&node).map_or("none".to_owned(), |heard| heard.text(spacecraft.now()));
            let [nominal, redundant] = Bus::ALL.map(|bus| counters(spacecraft, board, bus));
            let place = format!("{:.1} m", config.config().position_m);
            let _ = write!(
                table,
                "\n{node:>4}  {place:<7}  {power:<5}  {heartbeat:<34}  {nominal:>15}  {redundant:>9}"
            );
        }
        table
    }
}

impl Heartbeat {
    fn text(&self, now: Time) -> String {
        // Bit 7 is the toggle bit of node guarding. No boot-up message has it.
        let state = match self.state {
            0 => "boot-up",
            4 | 0x84 => "stopped",
            5 | 0x85 => "operational",
            0x7F | 0xFF => "pre-operational",
            _ => "unknown state",
        };
        let ago = now.as_secs_f64() - self.at.as_secs_f64();
        format!("{state}, {}, {ago:.2} s ago", self.bus)
    }
}

/// Error counters of a board's controller on a bus.
fn counters(spacecraft: &Spacecraft, board: BoardId, bus: Bus) -> String {
    let places = [Side::Can1, Side::Can2].map(|side| spacecraft.place(board, side));
    let place = places.into_iter().flatten().find(|(wire, _)| *wire == bus);
    place.map_or("-".to_owned(), |(_, index)| {
        let counters = spacecraft.wire(bus).error_counters(index);
        format!("{}/{}", counters.transmit, counters.receive)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// States of CiA 301 7.2.8.3.2.2, where bit 7 is reserved.
    #[test]
    fn state_is_that_without_bit_7_and_80h_is_none() {
        for (state, expected) in [
            (0x00, "boot-up"),
            (0x04, "stopped"),
            (0x85, "operational"),
            (0xFF, "pre-operational"),
            (0x80, "unknown state"),
            (0x86, "unknown state"),
        ] {
            let heartbeat = Heartbeat { at: Time::ZERO, bus: Bus::Nominal, state };
            let text = heartbeat.text(Time::from_ms(100));
            assert_eq!(text, format!("{expected}, nominal, 0.10 s ago"), "{state:02X}h");
        }
    }
}
