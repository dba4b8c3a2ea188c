//! Process data objects: [`async_canopen::pdo`].

pub use async_canopen::pdo::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::pdo::machine::*;
