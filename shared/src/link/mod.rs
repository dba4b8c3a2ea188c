//! The data link below the protocol: frames, buses, ports, queues.

pub mod bit_timing;
mod bus;
mod cob_id;
mod cob_id_entry;
mod frame;
pub mod port;
pub mod queue;

pub use bus::{Bus, PerBus};
pub use cob_id::CobId;
pub use cob_id_entry::{CobIdEntry, EntryUse};
pub use frame::{Frame, FrameError};
