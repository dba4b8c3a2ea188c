//! Budget of a node that sends too many frames: counted and reported (ECSS 5.3.3.1b).

use easy_ext::ext;

use super::Services;
use crate::emcy::ErrorCode;
use crate::link::budget::Over;
use crate::node::SpacecraftDevice;
use crate::types::CobId;

/// Source of the emergency that reports a COB-ID; its function code is in the low four bits.
const COB_ID: u8 = 0x10;
/// Source of the one that reports the node.
const NODE: u8 = 0x20;

#[ext(BudgetServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Counts a refused frame. Returns `false` if this error is active already.
    #[inline(always)] // called from one place
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
