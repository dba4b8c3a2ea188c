//! ECSS-E-ST-50-15C, the CANbus extension protocol for spacecraft, on top of CANopen.
//!
//! A spacecraft has two CAN buses, *nominal* and *redundant*. A **master** and its **slaves** are connected to both. The
//! master sends its heartbeat on one of them, the *active* bus, and the slaves follow it. All nodes share one time.
//!
//! The protocol is *sans-IO*: each service is a plain struct without input or output of its own. It takes frames and the
//! time, and returns frames and actions. Submodules named `machine` have these structs; users of a node need none of them. Only
//! [`runner`] is async.
//!
//! # Where to begin
//!
//! | you want to | read |
//! | --- | --- |
//! | write a slave | the tour below, [`node::Device`], [`od`] for objects, [`pdo`] for PDOs, [`node::SlaveEvent`] |
//! | write a master | [`node::Master`], [`profile::Profile`], [`boot`], [`runner::SdoClient`], [`node::MasterEvent`] |
//! | port it to another chip | [`link::port::CanPort`], [`runner::Clock`], [`runner::Platform`], [`link::bit_timing`] |
//!
//! # A tour
//!
//! A device is a struct of objects, with the PDOs that carry them. The mock board stands for a real one: a port for each bus
//! and a clock.
//!
#![cfg_attr(feature = "mock", doc = "```")]
#![cfg_attr(not(feature = "mock"), doc = "```ignore")]
//! use ecss_can::mock::{LoopbackPort, ManualClock, MockBoard, Tasks};
//! use ecss_can::nmt::{Command, NmtMessage};
//! use ecss_can::prelude::*;
//!
//! /// A thermometer.
//! #[derive(Objects)]
//! #[objects(device)]
//! struct Thermometer {
//!     /// Temperature
//!     ///
//!     /// In units of 0.1 °C.
//!     #[object(0x6000, ro, pdo)]
//!     temperature: i16,
//! }
//!
//! impl Device for Thermometer {
//!     type Pdos = PdoObjects<4, 4>;
//!     type Consumers = HeartbeatConsumers<1>;
//!     const PDOS: PdoSet = PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x280)).map(Thermometer::TEMPERATURE).transmit(2)]);
//! }
//!
//! static DIAGNOSTICS: Diagnostics = Diagnostics::new();
//! static RESOURCES: Resources<MockBoard, Slave<Thermometer>> = Resources::new();
//!
//! let clock = ManualClock::new();
//! let ports = PerBus::from_fn(|_| LoopbackPort::new(&clock));
//! let slave = || Slave::builder(NodeId::of::<3>(), &Profile::DEFAULT, Thermometer::default()).build();
//! let (slave, _events, runners) = RESOURCES.start(slave, Connection { ports: ports.clone(), clock }, &DIAGNOSTICS);
//! let mut tasks = Tasks::new(runners); // on a board: one task for each runner
//! tasks.run();
//! ports.nominal.receive(NmtMessage { command: Command::Start, target: Target::All }.encode());
//! tasks.run();
//! slave.update(|thermometer| thermometer.temperature = 215);
//! tasks.run();
//!
//! // Boot-up message, heartbeat after the start command, and the PDO with the new temperature.
//! let sent: Vec<_> = ports.nominal.sent().iter().map(|frame| (frame.id().raw(), frame.data().to_vec())).collect();
//! assert_eq!(sent, [(0x703, vec![0x00]), (0x703, vec![0x05]), (0x283, vec![215, 0])]);
//! ```
//!
//! `firmware/examples` has the same as an image for a board, with its master.
//!
//! # Modules
//!
//! A module uses only modules above it in this table. Those of CANopen are of the crate [`async_canopen`], which stands alone.
//!
//! | module | contents |
//! | --- | --- |
//! | [`types`] | frames, identifiers, instants, spacecraft time: words of the field without behaviour |
//! | [`link`] | ports, filters, transmit queue, bit timing, budgets, stamps |
//! | [`od`] | object dictionary: declarations, data types, access |
//! | [`time`] | local clock, and the service that steers it |
//! | [`nmt`] | network management: NMT state machine, commands, guards |
//! | [`heartbeat`], [`sync`], [`emcy`] | producers and consumers of heartbeats, SYNC, emergencies |
//! | [`sdo`] | SDO server and client |
//! | [`pdo`] | receive and transmit PDOs, their declaration, sequences of commands |
//! | [`redundancy`] | choice of the active bus: master, standby, slave |
//! | [`store`] | parameters that outlive a reset |
//! | [`boot`] | boot-up of the network by its master |
//! | [`profile`] | numbers of a mission |
//! | [`node`] | master and slave of a spacecraft, plain CANopen slave, minimal slave |
//! | [`runner`] | async shell: tasks of a node, handle of the application |
//! | [`prelude`] | names for a device and its `main` |
//! | `mock` | mock board and mock spacecraft, for tests and examples (feature `mock`) |
//!
//! # Features
//!
//! - `defmt`: every public type implements `defmt::Format`.
//! - `mock`: the module `mock`. It needs an allocator; the rest of the crate has no heap.
//!
//! Related crates: [`async-canopen`](https://docs.rs/async-canopen),
//! [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4), [`ecss-can-worlds`](https://docs.rs/ecss-can-worlds),
//! [`ecss-can-eds`](https://docs.rs/ecss-can-eds), [`can-twin`](https://docs.rs/can-twin).

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "mock")]
extern crate alloc;
// The derive macros name this crate from outside, also in here.
extern crate self as ecss_can;

// Users name one crate.
pub use async_canopen::{boot, heartbeat, link, nmt, od, pdo, sdo, sync};

pub mod emcy;
#[cfg(feature = "mock")]
pub mod mock;
pub mod node;
pub mod prelude;
pub mod profile;
pub mod redundancy;
pub mod runner;
pub mod store;
pub mod time;
pub mod types;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
