//! Redundancy parameters in the dictionary (1016h, 1017h, 2000h).

use easy_ext::ext;

use super::Services;
use crate::heartbeat::{ConsumerSlots, HeartbeatTimes};
use crate::node::SpacecraftDevice;
use crate::redundancy::Parameters;
use crate::types::{Duration, Instant, NodeId};

#[ext(RedundancyServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Returns the redundancy parameters as the dictionary has them.
    pub fn written_redundancy(&self) -> Parameters {
        let objects = self.objects();
        let consumer = objects.consumers.time_of(NodeId::MASTER).unwrap_or(Duration::ZERO);
        let producer = objects.communication.heartbeat.period();
        objects.extension.redundancy(HeartbeatTimes { consumer, producer })
    }

    /// Writes the present parameters into 2000h. PDOs that carry a changed Bdefault or Ctoggle become due.
    pub fn show_redundancy(&mut self, parameters: &Parameters, now: Instant) {
        for at in self.objects_mut().extension.show_redundancy(parameters) {
            self.on_changed(at, now);
        }
    }
}
