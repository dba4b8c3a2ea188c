//! Network management of a node: [`async_canopen::nmt`].

pub use async_canopen::nmt::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::nmt::machine::*;
