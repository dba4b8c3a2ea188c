//! Parts of a node for crates that build nodes with more than CANopen.
//!
//! Such a crate implements [`Extension`] for its objects. A slave of it has a [`SlaveCore`], another node has [`Services`]. Users
//! of a node need none of this.

pub use super::buses::{BusNews, Buses};
pub use super::counters::BusCounters;
pub use super::events::{NodeEvent, SlaveEvents};
pub use super::services::{
    Dictionary, Extension, FIRST_REPORTED, Lifetimes, SdoStep, Services, assert_objects,
};
pub use super::slave_core::SlaveCore;
pub use super::storage::{NoStore, SaveEnd, Storage};
pub use super::turn::{Part, Timed, Wakes};
