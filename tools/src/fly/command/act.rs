//! Execution of commands.

use std::collections::BTreeMap;
use std::fmt::Write;

use can_twin::bxcan::Side;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft, WireRecord};
use can_twin::wire::fault::{Fault, Flip, Nodes, Place};
use can_twin::wire::time::Time;

use super::damage::Damage;
use super::load::LoadMeter;
use super::status::Heartbeats;
use super::{Command, Level, NoCommand, Switch};
use crate::images::support::node::Node;

/// Last bit of the longest frame with an 11-bit identifier: 98 bits, 24 stuff bits, and 10 bits from the delimiter of the CRC on
/// (ISO 11898-1 10.4).
const LAST_BIT: u8 = 131;

/// Executes commands on a spacecraft.
#[derive(Debug)]
pub struct Operator {
    boards: BTreeMap<Node, BoardId>,
    /// Positions of nodes on both buses that are no boards, metres from the master's end.
    others_m: Vec<f64>,
    heartbeats: Heartbeats,
    /// Load of each bus, nominal first.
    meters: [LoadMeter; 2],
    /// Faults of each bus, nominal first.
    damage: [Damage; 2],
    /// Last switching of each board's power.
    switched: BTreeMap<Node, Switch>,
    /// The run was ended by a command.
    pub is_over: bool,
}

impl Operator {
    /// Makes the operator of these boards. `others_m`: positions of nodes on both buses that are no boards, metres from the
    /// master's end.
    pub fn new(boards: BTreeMap<Node, BoardId>, others_m: Vec<f64>) -> Operator {
        Operator {
            boards,
            others_m,
            heartbeats: Heartbeats::default(),
            meters: Default::default(),
            damage: Default::default(),
            switched: BTreeMap::new(),
            is_over: false,
        }
    }

    /// Observes an event of the wires.
    pub fn observe(&mut self, record: &WireRecord) {
        self.heartbeats.observe(record);
        if let Some(nth) = Bus::ALL.iter().position(|bus| *bus == record.bus) {
            self.meters[nth].observe(&record.record);
        }
    }

    /// Advances to `now`, up to which all events were observed.
    pub fn advance(&mut self, now: Time) {
        self.meters.iter_mut().for_each(|meter| meter.advance(now));
    }

    /// Ends the measurement at `now`. Returns the loads of each bus, nominal first.
    pub fn conclude(&mut self, now: Time) -> &[LoadMeter; 2] {
        self.meters.iter_mut().for_each(|meter| meter.finish(now));
        &self.meters
    }

    /// Executes a line and returns the response. A command that changes nothing is answered with "already".
    ///
    /// # Errors
    /// When it is no command, or one that cannot be executed: the reason.
    pub fn obey(&mut self, line: &str, spacecraft: &mut Spacecraft) -> Result<String, String> {
        let command = match line.parse::<Command>() {
            Ok(command) => command,
            Err(NoCommand::Help(text)) => return Ok(text),
            Err(NoCommand::Mistake(text)) => return Err(text),
        };
        self.execute(command, spacecraft)
    }

    /// Executes a command and returns the response. Begins with "done" if the command changed something.
    ///
    /// # Errors
    /// When it cannot be executed: the reason.
    pub fn execute(&mut self, command: Command, spacecraft: &mut Spacecraft) -> Result<String, String> {
        match command {
            Command::Cut { bus, metres } if self.damage(bus).is_cut(Some(metres)) => {
                Ok(format!("already cut at {metres} m"))
            }
            Command::Cut { bus, metres: position_m } => {
                let places = self.places(spacecraft, bus);
                let (first, last) = (places[0], places[places.len() - 1]);
                if !(first < position_m && position_m <= last) {
                    return Err(format!(
                        "a break at {position_m} m separates nothing: the nodes of the {bus} bus are between {first:.1} m and {last:.1} m; \
                         allowed are places behind the first one, up to the last one"
                    ));
                }
                let is_between = |place: &f64, cut: f64| (*place < cut) != (*place < position_m);
                let mut cuts = self.damage(bus).cuts.iter();
                if let Some(cut) = cuts.find(|cut| !places.iter().any(|place| is_between(place, **cut))) {
                    return Ok(format!("already cut at {cut} m, and no node is between"));
                }
                strike(spacecraft, bus, Fault::Cut { position_m })?;
                self.damage(bus).cut(position_m);
                done()
            }
            Command::Heal { bus, metres } if !self.damage(bus).is_cut(metres) => {
                let place = metres.map_or(String::new(), |metres| format!(" at {metres} m"));
                Ok(format!("already whole{place}; {bus} bus: {}", self.damage(bus)))
            }
            Command::Heal { bus, metres } => {
                let one = |position_m| Fault::Restore { position_m };
                strike(spacecraft, bus, metres.map_or(Fault::RestoreAll, one))?;
                self.damage(bus).heal(metres);
                done()
            }
            Command::Short { bus, metres: position_m, level } => {
                let short = self.damage(bus).short_of_piece(position_m);
                if let Some((metres, _)) = short.filter(|(_, was)| *was == level) {
                    return Ok(format!("already shorted at {metres} m, {level}"));
                }
                strike(spacecraft, bus, Fault::Short { position_m, level: level == Level::Recessive })?;
                self.damage(bus).short(position_m, level);
                done()
            }
            Command::Clear { bus } if self.damage(bus).shorts.is_empty() => {
                Ok("already without a short".into())
            }
            Command::Clear { bus } => {
                strike(spacecraft, bus, Fault::ClearShorts)?;
                self.damage(bus).shorts.clear();
                done()
            }
            Command::Power { node, to } => self.switch(spacecraft, node, to),
            Command::Reset { node } => {
                self.check_power(spacecraft, node)?;
                spacecraft.reset(self.board(node)?);
                done()
            }
            Command::Flip { bus, bit, nodes } => {
                let seen = self.on_wire(spacecraft, bus, &nodes)?;
                nodes.iter().try_for_each(|node| self.check_power(spacecraft, *node))?;
                strike(spacecraft, bus, Fault::Flip(Flip::new(Place::Bit(bit.into()), seen)))?;
                if bit > LAST_BIT {
                    return Ok(format!("done; only a frame with a 29-bit identifier has bit {bit}"));
                }
                done()
            }
            Command::Babble { node, bus, frame }
                if self.damage(bus).babbling.get(&node) == Some(&frame.0) =>
            {
                Ok(format!("already babbling {frame}"))
            }
            Command::Babble { node, bus, frame } => {
                let index = self.index(spacecraft, bus, node)?;
                self.check_power(spacecraft, node)?;
                strike(spacecraft, bus, Fault::Babble(index, frame.0))?;
                self.damage(bus).babbling.insert(node, frame.0);
                done()
            }
            Command::Quiet { node, bus } => {
                let index = self.index(spacecraft, bus, node)?;
                if !self.damage(bus).babbling.contains_key(&node) {
                    return Ok("already quiet".into());
                }
                strike(spacecraft, bus, Fault::StopBabbling(index))?;
                self.damage(bus).babbling.remove(&node);
                done()
            }
            Command::Status => Ok(self.status(spacecraft)),
            Command::Quit => {
                self.is_over = true;
                done()
            }
        }
    }

    /// Switches the power of a board.
    fn switch(&mut self, spacecraft: &mut Spacecraft, node: Node, to: Switch) -> Result<String, String> {
        let board = self.board(node)?;
        let is_on = self.is_powered(spacecraft, node)?;
        let first = spacecraft.board(board).config().power_on_at;
        match (is_on, to) {
            (true, Switch::On) => Ok("already on".into()),
            (false, Switch::Off) if spacecraft.now() < first => {
                Ok(format!("already off; it gets power at {:.3} s", first.as_secs_f64()))
            }
            (false, Switch::Off) => Ok("already off".into()),
            (true, Switch::Off) | (false, Switch::On) => {
                spacecraft.power(board, to == Switch::On);
                self.switched.insert(node, to);
                done()
            }
        }
    }

    /// Returns whether a board has power by the last command, which the spacecraft executes a moment later.
    fn is_powered(&self, spacecraft: &Spacecraft, node: Node) -> Result<bool, String> {
        let board = self.board(node)?;
        let switched = self.switched.get(&node).map(|to| *to == Switch::On);
        Ok(switched.unwrap_or_else(|| spacecraft.board(board).is_powered()))
    }

    /// # Errors
    /// When a board has no power.
    fn check_power(&self, spacecraft: &Spacecraft, node: Node) -> Result<(), String> {
        match self.is_powered(spacecraft, node)? {
            true => Ok(()),
            false => Err(format!("node {node} has no power: power {node} on")),
        }
    }

    /// Returns the positions of the nodes of a bus, metres from the master's end, ascending.
    fn places(&self, spacecraft: &Spacecraft, bus: Bus) -> Vec<f64> {
        let is_here = |node: &Node| self.index(spacecraft, bus, *node).is_ok();
        let boards = self.boards.iter().filter(|(node, _)| is_here(node));
        let places = boards.map(|(_, board)| spacecraft.board(*board).config().position_m);
        let mut places: Vec<f64> = places.chain(self.others_m.iter().copied()).collect();
        places.sort_by(f64::total_cmp);
        places
    }

    fn damage(&mut self, bus: Bus) -> &mut Damage {
        &mut self.damage[bus as usize]
    }

    /// Returns the state of boards and buses with their faults.
    fn status(&self, spacecraft: &Spacecraft) -> String {
        let mut text = self.heartbeats.status(&self.boards, spacecraft);
        let is_off = |board: BoardId| !spacecraft.board(board).is_powered();
        let off = self.boards.iter().filter(|(_, board)| is_off(**board));
        let off: Vec<String> = off.map(|(node, _)| format!("node {node}")).collect();
        if !off.is_empty() {
            let _ = write!(text, "\nwithout power: {}", off.join(", "));
        }
        for (bus, (meter, damage)) in Bus::ALL.into_iter().zip(self.meters.iter().zip(&self.damage)) {
            let counters = spacecraft.wire(bus).counters();
            let load = meter.last.map_or("known after the first second".into(), |load| load.to_string());
            let _ = write!(
                text,
                "\n{bus} bus: {damage}; load {load}; {} frames, {} destroyed, {} that nobody acknowledged",
                counters.completed, counters.destroyed, counters.ack_errors
            );
        }
        text
    }

    fn board(&self, node: Node) -> Result<BoardId, String> {
        self.boards.get(&node).copied().ok_or_else(|| {
            let nodes: Vec<String> = self.boards.keys().map(ToString::to_string).collect();
            format!("there is no node {node}: allowed are {}", nodes.join(", "))
        })
    }

    /// Index of a board on the wire of a bus.
    fn index(&self, spacecraft: &Spacecraft, bus: Bus, node: Node) -> Result<usize, String> {
        let board = self.board(node)?;
        let places = [Side::Can1, Side::Can2].map(|side| spacecraft.place(board, side));
        let found = places.into_iter().flatten().find(|(wire, _)| *wire == bus);
        found.map(|(_, index)| index).ok_or_else(|| format!("node {node} is not on this bus"))
    }

    fn on_wire(&self, spacecraft: &Spacecraft, bus: Bus, nodes: &[Node]) -> Result<Nodes, String> {
        if nodes.is_empty() {
            return Ok(Nodes::ALL);
        }
        let indices = nodes.iter().map(|node| self.index(spacecraft, bus, *node));
        Ok(Nodes::of(&indices.collect::<Result<Vec<_>, _>>()?))
    }
}

fn done() -> Result<String, String> {
    Ok("done".to_owned())
}

fn strike(spacecraft: &mut Spacecraft, bus: Bus, fault: Fault) -> Result<(), String> {
    let at = spacecraft.now().max(spacecraft.wire(bus).now());
    spacecraft.wire_mut(bus).schedule(at, fault).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests;
