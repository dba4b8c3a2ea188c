//! Async shell of a node: a runner for each bus, a runner for everything that is due, and the handle of the
//! application.
//!
//! A *runner* is the future of a task. The user owns the storage of the node, [`Resources`]. [`Resources::start`]
//! powers the node on. It returns three runners, each for a task of its own, a [`Handle`] to the node, and its
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
//! # use ecss_can::mock::{LoopbackPort, ManualClock, MockBoard, Tasks, poll_once};
//! # use ecss_can::prelude::*;
//! # /// A device without objects.
//! # #[derive(Objects)]
//! # #[objects(device)]
//! # struct Bare {}
//! # impl Device for Bare {
//! #     type Pdos = PdoObjects<0, 0>;
//! #     type Consumers = HeartbeatConsumers<1>;
//! #     const PDOS: PdoSet = PdoSet::NONE;
//! # }
//! type Resources = ecss_can::runner::Resources<MockBoard, Slave<Bare>>;
//! static RESOURCES: Resources = Resources::new();
//! static DIAGNOSTICS: Diagnostics = Diagnostics::new();
//!
//! let clock = ManualClock::new();
//! let ports = PerBus::from_fn(|_| LoopbackPort::new(&clock));
//! let slave = || Slave::builder(NodeId::of::<3>(), &Profile::DEFAULT, Bare::default()).build();
//! let (slave, mut events, runners) = RESOURCES.start(slave, Connection { ports, clock }, &DIAGNOSTICS);
//!
//! let mut tasks = Tasks::new(runners); // on a board: `runners.nominal.run().await` in a task, and so on
//! tasks.run();
//! assert!(poll_once(events.next()).is_some()); // in the application: `events.next().await`
//! assert_eq!(slave.status().active, Bus::Nominal);
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
//! - [`Resources::start`] panics when it is called twice.

mod cable;
mod master;
mod minimal;
mod slave;
mod spacecraft_clock;

pub use async_canopen::runner::*;
pub use cable::Cable;
pub use master::MasterHandle;
pub use minimal::MinimalHandle;
pub use slave::SlaveHandle;
pub use spacecraft_clock::{SpacecraftClock, TimeHandle};

use crate::node::Master;
use crate::redundancy::OneBoard;

/// SDO client of the master with this device.
pub type SdoClient<B, D, M = OneBoard> = async_canopen::runner::SdoClient<B, Master<D, M>>;
