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
pub use node_task::{Node, Outbox, node_task};
pub use sdo_client::SdoClient;
pub use telltale::{Interrupts, Stamps, Tally, Telltale};

use crate::link::port::{Filter, Health};
use crate::link::queue::Outgoing;
use crate::link::{Bus, Frame, PerBus};
use crate::time::Stamp;

/// Events that may wait for a node; before them wait those of the ports.
pub const EVENT_DEPTH: usize = 16;
/// Commands on their way to a bus: those it has not taken yet stay in the outbox.
pub const COMMAND_DEPTH: usize = 8;
/// Commands in an outbox, and frames in the priority queue of a bus.
pub const QUEUE_DEPTH: usize = 32;
/// Events and requests that may wait between node and application.
pub const APP_DEPTH: usize = 16;
/// Acceptance filters of a port.
pub const MAX_FILTERS: usize = 28;

/// Acceptance filters of a node.
pub type Filters = heapless::Vec<Filter, MAX_FILTERS>;

/// What a bus tells its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum LinkEvent {
    /// A frame that passed the filters.
    Received {
        /// The frame.
        frame: Frame,
        /// End of the frame.
        stamp: Stamp,
    },
    /// A frame of ours was acknowledged by a peer.
    Transmitted {
        /// The frame.
        frame: Frame,
        /// End of the frame.
        stamp: Stamp,
    },
    /// A frame of ours did not go out.
    Failed {
        /// The frame.
        frame: Frame,
        /// Why.
        cause: FailCause,
    },
    /// Frames of ours were dropped before they came to the bus: the outbox was full.
    Unsent {
        /// How many since the last report.
        frames: u16,
    },
    /// Received frames were lost before the node could see them.
    Overrun {
        /// How many since the last report, at least.
        lost: u16,
    },
    /// The error state of the controller changed.
    Health(Health),
    /// Its error counters moved since they were told last; told before the next event of the controller.
    Counters(Health),
    /// The controller does not get on or off the bus: it is defective, or the bus is dominant all the time.
    Stalled,
}

/// Why a frame did not go out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailCause {
    /// The node left the bus while the frame was pending.
    BusLeft,
    /// Its lifetime ended.
    Expired,
    /// The transmit queue was full, or a frame that the network lives on took its place there.
    QueueFull,
    /// The controller gave the frame up by itself (bus-off, reset).
    Aborted,
}

/// What a node wants of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum BusCommand {
    /// Send a frame.
    Send(Outgoing),
    /// Abort everything pending, queue and mailboxes; stay on the bus (parallel access).
    Abandon,
    /// Take part in the bus.
    Join,
    /// Abort everything pending and go off the bus, silent (selective access).
    Leave,
    /// Begin recovery from bus-off.
    Recover,
    /// Admit other frames by one of the filters set at the start.
    Filter {
        /// Number of the filter.
        number: u8,
        /// What it admits from now on.
        filter: Filter,
    },
}

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
