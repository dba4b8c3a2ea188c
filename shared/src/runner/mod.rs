//! The async shell: one task per bus, one per node, and the channels between them.
//!
//! ```text
//! CanPort ── bus_task ──┐                          ┌── application
//!                       ├── Links ── node_task ── AppLink
//! CanPort ── bus_task ──┘
//! ```
//!
//! The user owns the storage ([`NodeCell`], [`Links`], [`AppLink`], [`Telltale`]) and spawns [`bus_task`] once per controller and
//! [`node_task`] once per node. Nothing here knows a HAL or an executor.
//!
//! What goes through the channels is small and moves in words: events and commands have a tag of a word (`repr(u32)`),
//! because the compiler moves tag and rest apart, and behind a tag of a byte the rest goes byte by byte. Everything else,
//! the object dictionary above all, the application reads and writes in the [`NodeCell`].

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

use crate::node::{APP_DEPTH, BusCommand, LinkEvent};
use crate::types::{Bus, PerBus};

/// Events that may wait for a node; before them wait those of the ports.
pub const EVENT_DEPTH: usize = 16;
/// Commands on their way to a bus: those it has not taken yet stay in the outbox.
pub const COMMAND_DEPTH: usize = 8;
/// The channels between a node and its two buses.
pub struct Links<M: RawMutex> {
    events: Channel<M, (Bus, LinkEvent), EVENT_DEPTH>,
    commands: PerBus<Channel<M, BusCommand, COMMAND_DEPTH>>,
}

impl<M: RawMutex> Links<M> {
    /// Empty channels.
    pub const fn new() -> Self {
        Links {
            events: Channel::new(),
            commands: PerBus { nominal: Channel::new(), redundant: Channel::new() },
        }
    }
}

impl<M: RawMutex> Default for Links<M> {
    fn default() -> Self {
        Self::new()
    }
}

/// The channels between a node and its application: `E` events to it, `R` requests from it.
pub struct AppLink<M: RawMutex, E, R> {
    /// What the node tells the application.
    pub events: Channel<M, E, APP_DEPTH>,
    /// What the application wants of the node.
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
