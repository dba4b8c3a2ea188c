//! The async shell: a runner per bus, a runner for what is due, and the node that they share.
//!
//! ```text
//! CanPort ── BusRunner ──┐
//!                        ├── node ── Handle, Events ── application
//! CanPort ── BusRunner ──┤
//! Clock ──── DueRunner ──┘
//! ```
//!
//! The user owns the storage, [`Resources`]. [`Resources::start`] powers the node on and returns the three runners, each for a
//! task of its own, and what the application has: a [`Handle`] to the node and its [`Events`]. Nothing here knows a HAL or an
//! executor. All tasks of a node run in one executor: its storage cannot be shared with another thread or an interrupt.
//!
//! A received frame passes through no channel: the runner of its bus takes it from the port, and the node handles it in place.
//! What moves is small and moves in words: events and commands have a tag of a word (`repr(u32)`), because the compiler moves
//! tag and rest apart, and behind a tag of a byte the rest goes byte by byte.

mod alarm;
mod bus;
mod cable;
mod due;
mod filters;
mod handle;
mod resources;
mod sdo_client;
mod shared;
mod single;
mod spacecraft_clock;
mod telltale;

pub use bus::BusRunner;
pub use cable::Cable;
pub use due::DueRunner;
pub use handle::{Events, Handle};
pub use resources::{Platform, Resources, Runners};
pub use sdo_client::SdoClient;
pub use single::{Single, SingleRunners};
pub use spacecraft_clock::SpacecraftClock;
pub use telltale::{Interrupts, Stamps, Tally, Telltale};

/// Events that a bus handles before other tasks have their turn.
const TURN: usize = 2;
