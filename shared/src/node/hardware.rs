//! Parts of a board that its node uses beside ports and clock.

use super::Upsets;
use crate::emcy::PostMortem;
use crate::store::{ParameterStore, RetainedMemory};

/// Parts of a board that its node uses beside ports and clock. The default has none of them.
///
/// A board fills it, and the builder of its node takes it: [`SlaveBuilder::hardware`](super::SlaveBuilder::hardware),
/// [`MasterBuilder::hardware`](super::MasterBuilder::hardware).
#[derive(Default)]
#[non_exhaustive]
pub struct Hardware {
    /// Parameter store. `None`: the node saves nothing.
    pub store: Option<&'static mut (dyn ParameterStore + Send)>,
    /// Memory that outlives a reset. A master does not use it.
    pub retained: Option<&'static mut (dyn RetainedMemory + Send)>,
    /// Record of the last reset (2032h).
    pub post_mortem: PostMortem,
    /// Pattern of late heartbeats, one bit for each heartbeat; zero: none is late. A master does not use it.
    pub late_heartbeats: u32,
    /// Upsets that the board finds in its registers (2033h). `None`: it looks for none.
    pub upsets: Option<&'static Upsets>,
}

impl core::fmt::Debug for Hardware {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Hardware")
            .field("store", &self.store.is_some())
            .field("retained", &self.retained.is_some())
            .field("post_mortem", &self.post_mortem)
            .field("late_heartbeats", &self.late_heartbeats)
            .field("upsets", &self.upsets)
            .finish()
    }
}
