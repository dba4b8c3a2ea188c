//! Mock of a board, for tests and examples of an application (feature `mock`).
//!
//! [`async_canopen::mock`] has the parts. A *mock board* has a clock that the test sets, [`ManualClock`], and a port for each bus, [`LoopbackPort`]. The port
//! acknowledges every frame of the node at once and keeps it for the test. [`Tasks`] runs the node without an executor.
//!
//! ```
//! use ecss_can::mock::{LoopbackPort, ManualClock, MockBoard, Tasks};
//! use ecss_can::prelude::*;
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
//! static RESOURCES: Resources<MockBoard, Slave<Bare>> = Resources::new();
//! let clock = ManualClock::new();
//! let ports = PerBus::from_fn(|_| LoopbackPort::new(&clock));
//! let slave = || Slave::builder(NodeId::of::<3>(), &Profile::DEFAULT, Bare::default()).build();
//! let connection = Connection { ports: ports.clone(), clock: clock.clone() };
//! let (_, mut events, runners) = RESOURCES.start(slave, connection, &DIAGNOSTICS);
//!
//! let mut tasks = Tasks::new(runners);
//! tasks.run();
//! clock.advance(Profile::DEFAULT.heartbeat);
//! tasks.run();
//! let sent = ports.nominal.sent();
//! assert_eq!(sent.len(), 2); // the boot-up message, and a heartbeat after its period
//! assert_eq!((sent[1].id().raw(), sent[1].data()), (0x703, &[0x7F][..]));
//! assert!(ecss_can::mock::poll_once(events.next()).is_some());
//! ```
//!
//! [`MockSpacecraft`] connects several nodes by two buses. One of these may be cut.
//!
//! # Limits
//!
//! The module needs an allocator. A port sends in no time: there is no arbitration, no bit error and no bus-off. The packages
//! The packages `can-twin` and `ecss-can-worlds` simulate these.

mod spacecraft;

pub use async_canopen::mock::{LoopbackPort, ManualClock, MockBoard, Tasks, poll_once};
pub use spacecraft::{MockSpacecraft, SentFrame};
