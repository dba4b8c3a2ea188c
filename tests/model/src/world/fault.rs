//! Events between two ticks, and those that are possible now.

use ecss_can::nmt::Command;
use ecss_can::types::{Bus, Instant};

use super::{MASTERS, SLAVES, World, loss};

/// Commands of a foreign master.
const COMMANDS: [Command; 5] = [
    Command::Start,
    Command::Stop,
    Command::EnterPreOperational,
    Command::ResetNode,
    Command::ResetCommunication,
];

/// An event between two ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// A node is cut from a bus, at its stub. In a line of three nodes every cut of a segment separates one node, too.
    Cut(Bus, usize),
    /// The stub is repaired, and its controller on the bus again.
    Restore(Bus, usize),
    /// The controller of the master is bus-off too often: the bus is failed for it.
    BusOff(Bus),
    /// The application of the master requests a bus.
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
    /// A node has power again.
    On(usize),
    /// The next frame of this kind that arrives at a node is lost there.
    Lose(usize, Kind),
    /// A foreign node sends this frame on a bus.
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

/// Frames of a node of the spacecraft that a foreign node sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Message {
    /// Heartbeat of the master.
    Heartbeat,
    /// Heartbeat of another node with the Node-ID of the slave with parallel access.
    OfSlave,
    /// The same heartbeat half a tick later, so that no heartbeat of that slave collides with it.
    OfSlaveLater,
    /// A module control command to all slaves.
    Command(Command),
}

impl World {
    /// Adds every fault that is possible `now`. With reports and without rounds, a master's stub stays cut at least
    /// until a slave misses the master, because losses by a shorter jolt are found only by rounds.
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
            // Commands of foreign nodes are searched without reports.
            if self.reporter.is_some() {
                continue;
            }
            faults.push(Fault::Foreign(bus, Message::Heartbeat));
            // The reaction of a slave does not depend on the number of masters.
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
