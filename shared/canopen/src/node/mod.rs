//! Nodes: all services put together, without input and output of their own.
//!
//! A *node* takes events of its bus and the time, and puts commands and events into an [`Outbox`]. A *device* is the
//! user's part of a node: its objects, its PDOs and its names, by the trait [`Device`]. [`CanopenSlave`] is a slave on one bus.
//!
//! The [`runner`](crate::runner) runs a node on its CAN controller. A test can call it directly:
//!
//! ```
//! use async_canopen::node::extend::{BusCommand, Outbox, Turn};
//! use async_canopen::node::{Event, Settings};
//! use async_canopen::prelude::*;
//! # /// A device without objects.
//! # #[derive(Objects)]
//! # #[objects(device)]
//! # struct Bare {}
//! # impl Device for Bare {
//! #     type Pdos = PdoObjects<0, 0>;
//! #     type Consumers = HeartbeatConsumers<1>;
//! #     const PDOS: PdoSet = PdoSet::NONE;
//! # }
//!
//! let mut slave = CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Bare::default());
//! let mut out = Outbox::new();
//! slave.start(&mut Turn::new(Instant::ZERO, &mut out));
//!
//! let mut sent = Vec::new();
//! while let Some((_, command)) = out.pop_command() {
//!     if let BusCommand::Send(outgoing) = command {
//!         sent.push((outgoing.frame.id().raw(), outgoing.frame.data().to_vec()));
//!     }
//! }
//! assert_eq!(sent, [(0x703, vec![0])]); // the boot-up message
//! assert_eq!(out.pop_event(), Some(Event::State(NmtState::PreOperational)));
//! assert!(slave.deadline().is_some()); // call `poll` then
//! ```
//!
//! # Limits
//!
//! - A node has the depth of its queues in its type, [`Node::Depth`]: 32 places, or fewer for a small node. A full queue
//!   refuses a frame and reports it.
//! - A slow application loses events. They are counted, and the node never waits.

mod buses;
mod canopen_slave;
mod changed_filters;
mod communication;
mod contract;
mod counters;
mod device;
mod events;
pub mod extend;
pub(crate) mod index;
mod messages;
mod outbox;
mod parts;
#[cfg(test)]
pub(crate) mod probe;
mod services;
mod settings;
mod slave_core;
mod turn;

pub use canopen_slave::CanopenSlave;
pub use communication::{Communication, Identity};
pub use contract::Node;
pub use counters::Counters;
pub(crate) use device::ClientNode;
pub use device::{Device, DeviceNode, DeviceObjects};
pub use events::Event;
pub use messages::FailCause;
pub(crate) use messages::{BusCommand, Filters, FullDepth, LinkEvent, MAX_FILTERS};
pub(crate) use outbox::Outbox;
pub use services::{CanopenOnly, NodeObjects, assert_device};
pub use settings::Settings;
pub(crate) use turn::Turn;
