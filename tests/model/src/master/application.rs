//! The application of the master of the model: it requests a bus, and stops a slave temporarily.

use ecss_can::nmt::{Command, NmtMessage, Target};
use ecss_can::types::{Bus, Instant, NodeId};

use super::Master;
use crate::profile::BREAK;
use crate::station::Station;

impl Master {
    /// Requests this bus.
    pub fn request(&mut self, bus: Bus, now: Instant) {
        self.redundancy.request(bus);
        self.poll(now);
    }

    /// Stops a slave until a [`BREAK`] is over.
    pub fn hold(&mut self, node: NodeId, now: Instant) {
        assert!(self.command(Command::Stop, node, now), "a slave that is stopped is held");
        self.held = Some((now + BREAK, node));
    }

    /// Returns whether a slave is stopped.
    pub fn is_holding(&self) -> bool {
        self.held.is_some()
    }

    /// Starts the slave that was stopped, when it is due.
    pub(super) fn release(&mut self, now: Instant) {
        if let Some((_, node)) = self.held.take_if(|(end, _)| *end <= now) {
            assert!(!self.command(Command::Start, node, now), "a slave that is started is not held");
        }
    }

    fn command(&mut self, command: Command, node: NodeId, now: Instant) -> bool {
        let target = Target::Node(node);
        let is_held = self.redundancy.on_command(command, target);
        self.send(NmtMessage { command, target }.encode(), now);
        is_held
    }
}
