//! Async shell of a node on one bus or on two: a runner for each bus, a runner for everything that is due, and the handle of the
//! application.
//!
//! A *runner* is the future of a task. The user owns the storage of the node: [`Single`], or [`Resources`] for two
//! buses. Its `start` powers the node on. It returns the runners, each for a task of its own, a [`Handle`] to the node, and its
//! [`Events`].
//!
//! ```text
//! CanPort ── BusRunner ──┐
//!                        ├── node ── Handle, Events ── application
//! CanPort ── BusRunner ──┤
//! Clock ──── DueRunner ──┘
//! ```
//!
//! The mock board of this example stands for a real one:
//!
#![cfg_attr(feature = "mock", doc = "```")]
#![cfg_attr(not(feature = "mock"), doc = "```ignore")]
//! # use async_canopen::mock::{LoopbackPort, ManualClock, MockBoard, Tasks, poll_once};
//! # use async_canopen::prelude::*;
//! # /// A device without objects.
//! # #[derive(Objects)]
//! # #[objects(device)]
//! # struct Bare {}
//! # impl Device for Bare {
//! #     type Pdos = PdoObjects<0, 0>;
//! #     type Consumers = HeartbeatConsumers<1>;
//! #     const PDOS: PdoSet = PdoSet::NONE;
//! # }
//! static RESOURCES: Single<MockBoard, CanopenSlave<Bare>> = Single::new();
//! static DIAGNOSTICS: Diagnostics = Diagnostics::new();
//!
//! let clock = ManualClock::new();
//! let port = LoopbackPort::new(&clock);
//! let slave = || CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Bare::default());
//! let (slave, mut events, runners) = RESOURCES.start(slave, Connection { ports: port, clock }, &DIAGNOSTICS);
//!
//! let mut tasks = Tasks::default();
//! tasks.spawn_single(runners); // on a board: `runners.bus.run().await` in a task, and so on
//! tasks.run();
//! assert!(poll_once(events.next()).is_some()); // in the application: `events.next().await`
//! assert_eq!(slave.state(), NmtState::PreOperational);
//! ```
//!
//! # How frames and events move
//!
//! The runner of a bus takes a received frame from its port, and the node handles it in place, without a channel.
//! Events and commands are small and are moved in words: they have a tag of one word (`repr(u32)`). After a tag of
//! one byte the compiler would move the rest byte by byte.
//!
//! # Limits
//!
//! - All tasks of a node run in one executor. The storage cannot be shared with another thread or an interrupt.
//! - The module uses no HAL and no executor.
//! - A closure that has the objects of a node cannot use a handle: see [`Outside`].
//! - `start` panics when it is called twice.

mod alarm;
mod bus;
mod canopen_slave;
mod connection;
mod diagnostics;
mod due;
pub mod extend;
mod filters;
mod handle;
mod left;
mod outside;
mod platform;
mod resources;
mod sdo_client;
mod shared;
mod single;
mod storage;

pub use bus::BusRunner;
pub use connection::Connection;
pub use diagnostics::{Diagnostics, Interrupts, Stamps, Tally};
pub use due::DueRunner;
pub use handle::{EventSource, Events, Handle};
pub use outside::Outside;
pub use platform::{Clock, Platform};
pub use resources::{Resources, Runners};
pub use sdo_client::SdoClient;
pub use single::{Single, SingleRunners};

/// Events that a bus handles before other tasks have their turn.
const TURN: usize = 2;
