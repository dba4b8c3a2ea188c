//! Mock of a board, for tests and examples of an application (feature `mock`).
//!
//! A *mock board* has a clock that the test sets, [`ManualClock`], and a port for each of its buses, [`LoopbackPort`]. The port
//! acknowledges every frame of the node at once and keeps it for the test. [`Tasks`] runs the node without an executor.
//!
//! ```
//! use async_canopen::mock::{LoopbackPort, ManualClock, MockBoard, Tasks, poll_once};
//! use async_canopen::prelude::*;
//!
//! /// A device without objects and PDOs of its own.
//! #[derive(Objects)]
//! #[objects(device)]
//! struct Bare {}
//!
//! impl Device for Bare {
//!     type Pdos = PdoObjects<0, 0>;
//!     type Consumers = HeartbeatConsumers<1>;
//!     const PDOS: PdoSet = PdoSet::NONE;
//! }
//!
//! static DIAGNOSTICS: Diagnostics = Diagnostics::new();
//! static RESOURCES: Single<MockBoard, CanopenSlave<Bare>> = Single::new();
//! let clock = ManualClock::new();
//! let port = LoopbackPort::new(&clock);
//! let slave = || CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Bare::default());
//! let connection = Connection { ports: port.clone(), clock: clock.clone() };
//! let (_, mut events, runners) = RESOURCES.start(slave, connection, &DIAGNOSTICS);
//!
//! let mut tasks = Tasks::default();
//! tasks.spawn_single(runners);
//! tasks.run();
//! clock.advance(Settings::DEFAULT.heartbeats.producer);
//! tasks.run();
//! let sent = port.sent();
//! assert_eq!(sent.len(), 2); // the boot-up message, and a heartbeat after its period
//! assert_eq!((sent[1].id().raw(), sent[1].data()), (0x703, &[0x7F][..]));
//! assert!(poll_once(events.next()).is_some());
//! ```
//!
//! # Limits
//!
//! The module needs an allocator. A port sends in no time: there is no arbitration, no bit error and no bus-off. The package `can-twin` of the
//! repository simulates these.

mod clock;
mod port;
mod tasks;

pub use clock::ManualClock;
pub use port::LoopbackPort;
pub use tasks::{Tasks, poll_once};

use crate::runner::Platform;

/// Mock board: a [`LoopbackPort`] for each bus and a [`ManualClock`].
pub struct MockBoard;

impl Platform for MockBoard {
    type Port = LoopbackPort;
    type Clock = ManualClock;
}
