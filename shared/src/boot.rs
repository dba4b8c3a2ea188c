//! Boot-up of the network by its master: [`async_canopen::boot`].

pub use async_canopen::boot::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::boot::machine::*;
