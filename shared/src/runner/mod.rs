//! The async shell: a task per bus, a task for what is due, and the node that they share.
//!
//! ```text
//! CanPort ── bus_task ──┐
//!                       ├── NodeCell ── application
//! CanPort ── bus_task ──┤
//! Clock ──── node_task ─┘
//! ```
//!
//! The user owns the storage ([`NodeCell`], [`AppLink`], [`Telltale`]) and spawns [`bus_task`] once per controller and
//! [`node_task`] once per node. Nothing here knows a HAL or an executor.
//!
//! A received frame passes through no channel: the task of its bus takes it from the port, and the node handles it in place.
//! What moves is small and moves in words: events and commands have a tag of a word (`repr(u32)`), because the compiler moves
//! tag and rest apart, and behind a tag of a byte the rest goes byte by byte.

mod alarm;
mod bus_task;
mod node_cell;
mod node_task;
mod sdo_client;
mod telltale;

use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::channel::Channel;

pub use bus_task::bus_task;
pub use node_cell::NodeCell;
pub use node_task::node_task;
pub use sdo_client::SdoClient;
pub use telltale::{Interrupts, Stamps, Tally, Telltale};

use crate::node::{APP_DEPTH, Node};

/// Events that a bus handles, and requests that a node takes, before other tasks have their turn.
const TURN: usize = 8;

/// The channels between a node and its application: `E` events to it, `R` requests from it.
pub struct AppLink<M: RawMutex, E, R> {
    /// Events from the node.
    pub events: Channel<M, E, APP_DEPTH>,
    /// Requests of the application.
    pub requests: Channel<M, R, APP_DEPTH>,
}

impl<M: RawMutex, E, R> AppLink<M, E, R> {
    /// Empty channels.
    pub const fn new() -> Self {
        AppLink { events: Channel::new(), requests: Channel::new() }
    }
}

impl<M: RawMutex, E, R> Default for AppLink<M, E, R> {
    fn default() -> Self {
        Self::new()
    }
}

/// Where a step of the node ends, whichever task made it.
struct Surroundings<'a, M: RawMutex, N: Node> {
    app: &'a AppLink<M, N::Event, N::Request>,
    telltale: &'a Telltale,
}
