//! Redundancy parameters (1016h, 1017h, 2000h), the record of the last reset (2032h), and the budget of a node that sends too
//! many frames (ECSS 5.3.3.1b).

use easy_ext::ext;

use super::Services;
use crate::emcy::ErrorCode;
use crate::heartbeat::machine::time_of;
use crate::heartbeat::{ConsumerSlots, HeartbeatTimes};
use crate::link::budget::Over;
use crate::node::SpacecraftDevice;
use crate::redundancy::Parameters;
use crate::types::{CobId, Duration, Instant, NodeId};

/// Source of the emergency that reports a COB-ID; its function code is in the low four bits.
const COB_ID: u8 = 0x10;
/// Source of the one that reports the node.
const NODE: u8 = 0x20;

#[ext(SpacecraftServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Returns the redundancy parameters as the dictionary has them.
    pub fn written_redundancy(&self) -> Parameters {
        let objects = self.objects();
        let consumer = time_of(objects.consumers.entries(), NodeId::MASTER).unwrap_or(Duration::ZERO);
        let producer = self.heartbeat_period();
        objects.extension.redundancy(HeartbeatTimes { consumer, producer })
    }

    /// Writes the present parameters into 2000h. PDOs that carry a changed Bdefault or Ctoggle become due.
    pub fn show_redundancy(&mut self, parameters: &Parameters, now: Instant) {
        for at in self.objects_mut().extension.show_redundancy(parameters) {
            self.on_changed(at, now);
        }
    }

    /// Notes that a heartbeat or boot-up message was sent.
    pub fn on_heartbeat_sent(&mut self) {
        if self.state_mut().take_reset() {
            self.report_reset();
        }
    }

    pub fn report_reset(&mut self) {
        if let Some((code, info)) = self.objects().extension.reset_emergency() {
            self.report_past(code, info);
        }
    }

    /// Counts a refused frame. Returns `false` if this error is active already.
    pub fn over_budget(&mut self, id: CobId, over: Over) -> bool {
        let raw = id.raw();
        self.objects_mut().extension.count_refused(id, over == Over::Node);
        let source = match over {
            Over::CobId => COB_ID | (raw >> 7) as u8,
            Over::Node => NODE,
            Over::Silent => return false,
        };
        let [low, high] = raw.to_le_bytes();
        self.raise(ErrorCode::COMMUNICATION, [source, low, high, 0, 0])
    }

    /// Notes that no frame was refused for a while: the error is gone.
    pub fn within_budget(&mut self) {
        let mut source = COB_ID;
        while source <= NODE {
            self.clear(ErrorCode::COMMUNICATION, source);
            source += 1;
        }
    }
}
