//! Service data objects: [`async_canopen::sdo`].

pub use async_canopen::sdo::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::sdo::machine::*;
