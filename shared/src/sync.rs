//! SYNC: [`async_canopen::sync`].

pub use async_canopen::sync::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::sync::machine::*;
