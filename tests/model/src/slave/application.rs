//! The application of a slave of the model: it chooses a bus, saves its parameters, and sends too many frames.

use ecss_can::link::access::BusAccess;
use ecss_can::types::{Bus, Instant};

use super::Slave;
use crate::profile::BREAK;
use crate::station::Station;

impl Slave {
    /// Chooses this bus. With parallel access the master chooses.
    pub fn choose(&mut self, bus: Bus, now: Instant) {
        let is_free = self.redundancy.choose(bus);
        assert_eq!(is_free, self.access == BusAccess::Selective, "{:?}", self.id);
        self.poll(now);
    }

    /// Silences the slave by its budget until a [`BREAK`] is over.
    pub fn silence(&mut self, now: Instant) {
        self.node.silence = Some(now + BREAK);
        self.decide(now, |redundancy, step| redundancy.silence(step));
        self.poll(now);
    }

    /// Saves its parameters.
    pub fn save(&mut self, now: Instant) {
        let stored = self.node.bdefault;
        self.node.stored = stored;
        self.decide(now, |redundancy, step| redundancy.on_stored(stored, step));
        self.poll(now);
    }

    /// Ends the silence, when it is due.
    pub(super) fn resume(&mut self, now: Instant) {
        if self.node.silence.take_if(|end| *end <= now).is_some() {
            self.redundancy.resume();
            self.boot(now);
        }
    }
}
