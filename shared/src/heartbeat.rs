//! Heartbeat and boot-up message: [`async_canopen::heartbeat`].

pub use async_canopen::heartbeat::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::heartbeat::machine::*;
