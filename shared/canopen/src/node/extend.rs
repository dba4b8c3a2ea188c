//! Parts of a node for crates that build nodes with more than CANopen.
//!
//! Such a crate implements [`Extension`] for its objects. A slave of it has a [`SlaveCore`], another node has [`Services`]. Users
//! of a node need none of this.

pub use super::buses::{BusNews, Buses};
pub use super::changed_filters::ChangedFilters;
pub use super::device::ClientNode;
pub use super::events::{NodeEvent, SlaveEvents};
pub use super::messages::{BusCommand, Filters, FullDepth, LinkEvent, MAX_FILTERS, QUEUE_DEPTH};
pub use super::outbox::Outbox;
pub use super::services::{Extension, FIRST_REPORTED, SdoStep, Services, assert_objects};
pub use super::slave_core::SlaveCore;
pub use super::turn::{Part, Timed, Turn, Wakes};

/// Indices of the objects that such a node checks and follows.
pub mod index {
    pub use crate::node::index::{
        CONSUMER_HEARTBEAT, LAST_TPDO_MAPPING, PRODUCER_HEARTBEAT, RPDO, STORE, SYNC_COB_ID, TPDO,
    };
}
