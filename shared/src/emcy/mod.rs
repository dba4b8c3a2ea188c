//! Emergencies: those of [`async_canopen::emcy`], and the record of the last reset (2032h), which one of them reports.

mod post_mortem;

pub use async_canopen::emcy::*;
// Nodes of this crate are made of these.
pub(crate) use async_canopen::emcy::machine::*;
pub use post_mortem::{PostMortem, PostMortemObjects};
