//! What can happen between two moments, and what of it can happen now.

use ecss_can::nmt::Command;
use ecss_can::types::{Bus, Instant};

use super::{MASTERS, SLAVES, World, loss};

/// What a foreign master commands.
const COMMANDS: [Command; 5] = [
    Command::Start,
    Command::Stop,
    Command::EnterPreOperational,
    Command::ResetNode,
    Command::ResetCommunication,
];

/// What happens between two moments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// A node is cut from a bus, at its stub. In a line of three nodes every cut of a segment separates one node, too.
    Cut(Bus, usize),
    /// The stub is mended, and its controller on the bus again.
    Restore(Bus, usize),
    /// The controller of the master is bus-off too often: the bus is failed for it.
    BusOff(Bus),
    /// The application of the master asks for a bus.
    Request(Bus),
    /// The application of the master stops a slave for a while.
    Hold(usize),
    /// The application of a slave chooses a bus.
    Choose(Bus, usize),
    /// The budget of a slave silences it for a while.
    Silence(usize),
    /// A slave saves its parameters.
    Save(usize),
    /// The chip of a node is reset.
    Reset(usize),
    /// A node loses its power.
    Off(usize),
    /// It has power again.
    On(usize),
    /// The next frame of this kind that arrives at a node is lost there.
    Lose(usize, Kind),
    /// A node that is none of ours sends this frame on a bus.
    Foreign(Bus, Message),
}

/// Frames that a receiver loses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A heartbeat or boot-up message.
    Heartbeat,
    /// A command of the master.
    Command,
}

/// Frames of one of ours that somebody else sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Message {
    /// Heartbeat of the master.
    Heartbeat,
    /// Heartbeat of the slave with parallel access: another node with its Node-ID.
    OfSlave,
    /// The same half a tick later: no heartbeat of that slave crosses it.
    OfSlaveLater,
    /// A module control command to all slaves.
    Command(Command),
}

impl World {
    /// Every fault that can happen `now`. With reports and without rounds, a stub of a master is cut at least as long as it takes a
    /// slave to miss the master: what a shorter jolt loses, only rounds find.
    pub fn faults(&self, now: Instant, faults: &mut Vec<Fault>) {
        for bus in Bus::ALL {
            for place in self.places() {
                if self.is_connected(bus, place) {
                    faults.push(Fault::Cut(bus, place));
                } else if !MASTERS.contains(&place) || self.mended_at <= now {
                    faults.push(Fault::Restore(bus, place));
                }
            }
            if self.is_in_use {
                self.events_of_use(bus, faults);
            }
            // What others command is searched without reports.
            if self.reporter.is_some() {
                continue;
            }
            faults.push(Fault::Foreign(bus, Message::Heartbeat));
            // How a slave reacts does not depend on the number of masters.
            if self.masters.len() == 1 {
                faults.push(Fault::Foreign(bus, Message::OfSlave));
            }
            faults.extend(COMMANDS.map(|command| Fault::Foreign(bus, Message::Command(command))));
        }
        for place in self.places() {
            if !self.is_powered(place) {
                faults.push(Fault::On(place));
                continue;
            }
            if !(self.is_memory_kept && MASTERS.contains(&place)) {
                faults.extend([Fault::Reset(place), Fault::Off(place)]);
            }
            for kind in [Kind::Heartbeat, Kind::Command] {
                if (!MASTERS.contains(&place) || kind == Kind::Heartbeat)
                    && self.losing & loss(place, kind) == 0
                {
                    faults.push(Fault::Lose(place, kind));
                }
            }
        }
    }

    fn events_of_use(&self, bus: Bus, faults: &mut Vec<Fault>) {
        faults.push(Fault::Foreign(bus, Message::OfSlaveLater));
        if self.is_connected(bus, MASTERS[0]) {
            faults.push(Fault::BusOff(bus));
        }
        if self.is_powered(MASTERS[0]) {
            faults.push(Fault::Request(bus));
        }
        for place in SLAVES.into_iter().filter(|place| self.is_powered(*place)) {
            faults.push(Fault::Choose(bus, place));
            // Once, not for each bus.
            if bus == Bus::Nominal {
                faults.extend([Fault::Silence(place), Fault::Save(place)]);
                if self.is_powered(MASTERS[0]) && !self.masters[0].is_holding() {
                    faults.push(Fault::Hold(place));
                }
            }
        }
    }
}
