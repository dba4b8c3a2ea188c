//! Boards of a spacecraft, as a table.

use std::collections::BTreeMap;
use std::fmt::Write;

use can_twin::bxcan::Side;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft, WireRecord};
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;

use crate::fly::meaning::{Meaning, NmtState, Scope};
use crate::images::support::node::Node;

/// The last heartbeat of each node.
#[derive(Debug, Default)]
pub struct Heartbeats(BTreeMap<Node, Heartbeat>);

#[derive(Clone, Copy, Debug)]
struct Heartbeat {
    at: Time,
    bus: Bus,
    /// NMT state; `None` after a boot-up message.
    state: Option<NmtState>,
}

impl Heartbeats {
    /// Observes an event of the wires.
    pub fn observe(&mut self, record: &WireRecord) {
        let Observation::Completed { trace, .. } = &record.record else { return };
        let (node, state) = match Meaning::decode(&trace.frame, Scope::Protocol) {
            Some(Meaning::BootUp { node }) => (node, None),
            Some(Meaning::Heartbeat { node, state }) => (node, Some(state)),
            _ => return,
        };
        self.0.insert(node, Heartbeat { at: trace.end, bus: record.bus, state });
    }

    /// Returns the table.
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
        let state = self.state.map_or("boot-up", NmtState::name);
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
