//! Redundancy parameters in the dictionary (1016h, 1017h, 2000h).

use easy_ext::ext;

use super::Services;
use crate::heartbeat::ConsumerSlots;
use crate::heartbeat::machine::monitored;
use crate::node::SpacecraftDevice;
use crate::redundancy::{Parameters, Redundancy, RedundancyObjects};
use crate::types::{Address, Duration, Instant, NodeId};

const BDEFAULT: Address = RedundancyObjects::PARAMETERS.field(Redundancy::BDEFAULT).address();
const CTOGGLE: Address = RedundancyObjects::PARAMETERS.field(Redundancy::CTOGGLE).address();

#[ext(RedundancyServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Returns the redundancy parameters as the dictionary has them.
    pub fn written_redundancy(&self) -> Parameters {
        let objects = &self.dictionary.objects;
        let of_master = |entry: &&u32| monitored(**entry) == Some(NodeId::MASTER);
        let consumer = objects.consumers.entries().iter().find(of_master);
        let time = consumer.map_or(0, |entry| entry & 0xFFFF);
        let producer = Duration::from_millis(u64::from(objects.communication.heartbeat.time));
        let consumer = Duration::from_millis(u64::from(time));
        objects.extension.redundancy.parameters.parameters(consumer, producer)
    }

    /// Writes the present parameters into 2000h. PDOs that carry a changed Bdefault or Ctoggle become due.
    pub fn show_redundancy(&mut self, parameters: &Parameters, now: Instant) {
        let objects = &mut self.dictionary.objects;
        let before = objects.extension.redundancy.parameters;
        objects.extension.set_redundancy(parameters);
        let after = objects.extension.redundancy.parameters;
        for (at, has_changed) in
            [(BDEFAULT, before.bdefault != after.bdefault), (CTOGGLE, before.ctoggle != after.ctoggle)]
        {
            if has_changed {
                self.dictionary.on_changed(at, now, &mut self.wakes);
            }
        }
    }
}
