//! Heartbeat and boot-up message: producer and consumers (CiA 301 7.2.8.2.2, 7.2.8.2.3; objects 1016h, 1017h).
//!
//! A *heartbeat* is a message with the NMT state of its node, sent with the period in 1017h. The *boot-up message*
//! is a heartbeat with the state Initialising. The *consumer time* in 1016h is the time without a heartbeat after
//! which a node is *missed*.
//!
//! ```
//! use async_canopen::heartbeat::{HeartbeatConsumers, self};
//! use async_canopen::heartbeat::machine::{Missed, Monitor, Producer};
//! use async_canopen::types::{Duration, Instant, NmtState, NodeId};
//!
//! let node = NodeId::of::<3>();
//! let mut producer = Producer::new(node, Duration::from_millis(100)); // 1017h
//! producer.restart(Instant::ZERO);
//! let at = producer.deadline().unwrap();
//! let frame = producer.poll(at, NmtState::Operational).unwrap();
//!
//! let mut monitor = Monitor::<HeartbeatConsumers<1>>::new();
//! monitor.set(1, 3 << 16 | 250); // 1016h sub 1: node 3, 250 ms
//! monitor.on_heartbeat(node, heartbeat::decode(&frame).unwrap(), at);
//! let late = at + Duration::from_millis(250);
//! assert_eq!(monitor.poll(late), Some(Missed { node, last: at }));
//! ```
//!
//! [`Staggered`] is the producer of a slave that shows a clash of two equal Node-IDs. [`NodeControl`] is the NMT slave
//! with its boot-up message and heartbeat.
//!
//! # Limits
//!
//! - Monitoring begins with the first heartbeat after the entry was written. A boot-up message alone does not start
//!   it.
//! - A node monitors at most 127 nodes, and each of them once.

mod consumer;
mod entry;
pub mod machine;
mod monitor;
mod node_control;
mod objects;
mod producer;
mod staggered;
mod times;

pub(crate) use entry::{check_entry, monitored};
pub(crate) use monitor::Monitor;
pub(crate) use node_control::NodeControl;
pub use objects::{ConsumerSlots, HeartbeatConsumers, HeartbeatProducer};
pub(crate) use producer::Producer;
pub(crate) use staggered::Staggered;
pub use times::HeartbeatTimes;

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

/// Returns whether it is a heartbeat with bit 7 set, which CiA 301 reserves. [`decode`] ignores the bit.
pub fn is_toggled(frame: &Frame) -> bool {
    is_heartbeat(frame.id()) && matches!(frame.data(), [0x80..=0xFF, ..])
}

/// Returns whether this COB-ID has the function code of heartbeats.
pub fn is_heartbeat(id: CobId) -> bool {
    id.function() == CobId::heartbeat(NodeId::MASTER).function()
}
