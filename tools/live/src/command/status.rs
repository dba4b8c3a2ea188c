//! Boards of a spacecraft, as a table.

use std::collections::BTreeMap;
use std::fmt::Write;

use can_wire::frame::WireId;
use can_wire::record::Observation;
use can_wire::time::Time;
use support::node::Node;
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
            let heartbeat = Heartbeat { at: trace.end, bus: record.bus, state: state & 0x7F };
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
        let state = match self.state {
            0 => "boot-up",
            4 => "stopped",
            5 => "operational",
            0x7F => "pre-operational",
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
