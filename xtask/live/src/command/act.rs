//! What a command does.

use std::collections::BTreeMap;

use can_wire::fault::{Fault, Flip, Nodes, Place};
use can_wire::time::Time;
use twin::bxcan::Side;
use twin::spacecraft::{BoardId, Bus, Spacecraft, WireRecord};

use super::status::Heartbeats;
use super::{Cable, Command, Level, Switch};
use support::craft::Node;

/// Does to a spacecraft what it is told.
#[derive(Debug)]
pub struct Operator {
    boards: BTreeMap<Node, BoardId>,
    heartbeats: Heartbeats,
    is_over: bool,
}

impl Operator {
    /// Of these boards.
    pub fn new(boards: BTreeMap<Node, BoardId>) -> Operator {
        Operator { boards, heartbeats: Heartbeats::default(), is_over: false }
    }

    /// Whether it was told to end the run.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// What was on the wires.
    pub fn observe(&mut self, record: &WireRecord) {
        self.heartbeats.observe(record);
    }

    /// Obeys a line; what there is to say of it.
    ///
    /// # Errors
    /// When it is no command, or one that cannot be obeyed: why.
    pub fn obey(&mut self, line: &str, spacecraft: &mut Spacecraft) -> Result<String, String> {
        let command: Command = line.parse()?;
        match command {
            Command::Cut { bus, metres: position_m } => strike(spacecraft, bus, Fault::Cut { position_m }),
            Command::Heal { bus, metres: Some(position_m) } => {
                strike(spacecraft, bus, Fault::Restore { position_m })
            }
            Command::Heal { bus, metres: None } => strike(spacecraft, bus, Fault::RestoreAll),
            Command::Short { bus, metres: position_m, level } => {
                strike(spacecraft, bus, Fault::Short { position_m, level: level == Level::Recessive })
            }
            Command::Clear { bus } => strike(spacecraft, bus, Fault::ClearShorts),
            Command::Power { node, to } => {
                let board = self.board(node)?;
                spacecraft.power(board, to == Switch::On);
                Ok(DONE.to_owned())
            }
            Command::Reset { node } => {
                let board = self.board(node)?;
                if !spacecraft.board(board).is_powered() {
                    return Err(format!("node {node} has no power: power {node} on"));
                }
                spacecraft.reset(board);
                Ok(DONE.to_owned())
            }
            Command::Flip { bus, bit, nodes } => {
                let seen = self.on_wire(spacecraft, bus, &nodes)?;
                strike(spacecraft, bus, Fault::Flip(Flip::new(Place::Bit(bit.into()), seen)))
            }
            Command::Babble { node, bus, frame } => {
                let index = self.index(spacecraft, bus, node)?;
                strike(spacecraft, bus, Fault::Babble(index, frame.0))
            }
            Command::Quiet { node, bus } => {
                let index = self.index(spacecraft, bus, node)?;
                strike(spacecraft, bus, Fault::StopBabbling(index))
            }
            Command::Status => Ok(self.heartbeats.status(&self.boards, spacecraft)),
            Command::Quit => {
                self.is_over = true;
                Ok(DONE.to_owned())
            }
        }
    }

    fn board(&self, node: Node) -> Result<BoardId, String> {
        self.boards.get(&node).copied().ok_or_else(|| {
            let nodes: Vec<String> = self.boards.keys().map(ToString::to_string).collect();
            format!("there is no node {node}: allowed are {}", nodes.join(", "))
        })
    }

    /// Index of a board on the wire of a bus.
    fn index(&self, spacecraft: &Spacecraft, bus: Cable, node: Node) -> Result<usize, String> {
        let board = self.board(node)?;
        let places = [Side::Can1, Side::Can2].map(|side| spacecraft.place(board, side));
        let found = places.into_iter().flatten().find(|(wire, _)| *wire == Bus::from(bus));
        found.map(|(_, index)| index).ok_or_else(|| format!("node {node} is not on this bus"))
    }

    fn on_wire(&self, spacecraft: &Spacecraft, bus: Cable, nodes: &[Node]) -> Result<Nodes, String> {
        if nodes.is_empty() {
            return Ok(Nodes::ALL);
        }
        let indices = nodes.iter().map(|node| self.index(spacecraft, bus, *node));
        Ok(Nodes::of(&indices.collect::<Result<Vec<_>, _>>()?))
    }
}

const DONE: &str = "done";

fn strike(spacecraft: &mut Spacecraft, bus: Cable, fault: Fault) -> Result<String, String> {
    let at = spacecraft.now() + Time(1);
    let wire = spacecraft.wire_mut(bus.into());
    wire.schedule(at, fault).map(|()| DONE.to_owned()).map_err(|error| error.to_string())
}
