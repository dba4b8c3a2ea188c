//! Heartbeat and boot-up: producer, messages, consumers (CiA 301 7.2.8.2.2, 7.2.8.2.3).

mod consumer;
mod monitor;
mod objects;
mod producer;
mod staggered;

pub use consumer::Consumer;
pub use monitor::{Heard, Missed, Monitor, check_entry};
pub use objects::{ConsumerSlots, HeartbeatConsumers, HeartbeatProducer};
pub use producer::Producer;
pub use staggered::Staggered;

use crate::types::{CobId, Frame, NmtState, NodeId};

/// Makes the heartbeat of `node`. With [`NmtState::Initialising`] it is the boot-up message.
pub fn encode(node: NodeId, state: NmtState) -> Frame {
    Frame::of(CobId::heartbeat(node), [state.byte()])
}

/// Returns the state that a heartbeat or boot-up message reports. `None` if the length is not 1 or the state is
/// unknown.
pub fn decode(frame: &Frame) -> Option<NmtState> {
    let &[byte] = frame.data() else { return None };
    NmtState::from_byte(byte)
}
