//! Values of a node that outlive a reset: the parameter set of CANopen, and what a spacecraft keeps beside it.
//!
//! | kept | where | ends with |
//! | --- | --- | --- |
//! | set of parameters (1010h, 1011h) | [`ParameterStore`] | the next set |
//! | *note*: Bdefault where a slave found its master (ECSS 8.3.3k, l) | one word beside the set | a newer set that has a Bdefault |
//! | Node-ID in three copies | beside both, see [`identity`] | another Node-ID |
//! | Bdefault, resets in a row | RAM that no start initialises, behind [`RetainedMemory`] | loss of power |
//!
//! [`async_canopen::store`] describes sets and saves. Here a [`Save`] keeps the noted Bdefault, and [`load`] applies it.
//!
//! # Limits
//!
//! - A node writes at most [`MOST_NOTES`](crate::redundancy::machine::Retained::MOST_NOTES) notes from power-on to power-off.

pub mod identity;
mod note;
mod retained;
mod running_save;

pub(crate) use async_canopen::store::machine::{Apply, SaveLimit};
pub use async_canopen::store::{
    Content, Group, LOAD, Loaded, Loss, ParameterStore, Parameters, Row, SAVE, StoreError, StoreObjects,
    StoreRequest, machine,
};
pub use note::{BdefaultNotes, Save, load, note_bdefault, noted_bdefault};
pub use retained::RetainedMemory;
pub(crate) use running_save::RunningSave;
