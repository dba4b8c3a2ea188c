//! CANopen (CiA 301) for embedded systems without an operating system and without a heap: a whole slave, and the services of
//! which it consists.
//!
//! A *slave* is a CANopen device on one bus: object dictionary, NMT, heartbeat, SYNC, EMCY, SDO server and PDOs. It runs on
//! any CAN controller with a [port](link::port::CanPort), and on any executor.
//!
//! # Where to begin
//!
//! | you want to | read |
//! | --- | --- |
//! | write a slave | the tour below, [`node::Device`], [`od`] for objects, [`pdo`] for PDOs, [`node::Event`] |
//! | connect it to a CAN controller | [`link::adapter`] over a driver, [`link::port::CanPort`] for registers, [`runner::Platform`] |
//! | test it | [`mock`](#features) |
//! | use one service alone | [the services](#services) |
//! | build another node | [`node::extend`], [`runner::extend`], and the modules named `machine` |
//!
//! # A tour
//!
//! A device is a struct of objects, with the PDOs that carry them. The mock board stands for a real one: a port and a clock.
//!
#![cfg_attr(feature = "mock", doc = "```")]
#![cfg_attr(not(feature = "mock"), doc = "```ignore")]
//! use async_canopen::mock::{LoopbackPort, ManualClock, MockBoard, Tasks};
//! use async_canopen::nmt::Command;
//! use async_canopen::prelude::*;
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
//!     /// Period of the measurement in milliseconds
//!     #[object(0x6001, rw, low = 10, default = 100)]
//!     period: u16,
//! }
//!
//! impl Device for Thermometer {
//!     type Pdos = PdoObjects<4, 4>;
//!     type Consumers = HeartbeatConsumers<1>;
//!     const PDOS: PdoSet = PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x180)).map(Thermometer::TEMPERATURE).transmit(1)]);
//! }
//!
//! static DIAGNOSTICS: Diagnostics = Diagnostics::new();
//! static NODE: Single<MockBoard, CanopenSlave<Thermometer>> = Single::new();
//!
//! let clock = ManualClock::new();
//! let port = LoopbackPort::new(&clock);
//! let slave = || CanopenSlave::new(NodeId::of::<3>(), &Settings::DEFAULT, Thermometer::default());
//! let (slave, _events, runners) = NODE.start(slave, Connection { ports: port.clone(), clock }, &DIAGNOSTICS);
//! let mut tasks = Tasks::default(); // on a board: one task for each runner
//! tasks.spawn_single(runners);
//! tasks.run();
//! port.receive(NmtMessage { command: Command::Start, target: Target::All }.encode());
//! tasks.run();
//! slave.update(|thermometer| thermometer.temperature = 215);
//! tasks.run();
//!
//! // Boot-up message, heartbeat after the start command, and the PDO with the new temperature.
//! let sent = || port.sent().iter().map(|frame| (frame.id().raw(), frame.data().to_vec())).collect::<Vec<_>>();
//! assert_eq!(sent(), [(0x703, vec![0x00]), (0x703, vec![0x05]), (0x183, vec![215, 0])]);
//!
//! // A client writes a period of 5 ms, which is too short: 0609 0032h.
//! let request = [0x2B, 0x01, 0x60, 0, 5, 0, 0, 0];
//! port.receive(Frame::of(CobId::sdo_request(NodeId::of::<3>()), request));
//! tasks.run();
//! assert_eq!(sent(), [(0x583, vec![0x80, 0x01, 0x60, 0, 0x32, 0x00, 0x09, 0x06])]);
//! assert_eq!(slave.read(|thermometer| thermometer.period), 100);
//! ```
//!
//! # Services
//!
//! The crate is *sans-IO*: each service is a plain struct without input or output of its own. It takes frames and the time, and
//! returns frames and actions. So a node of another kind, or a test, can use one service alone: those of each module are in its
//! submodule `machine`. Only [`runner`] is async.
//!
//! ```
//! use async_canopen::heartbeat::machine::Producer;
//! use async_canopen::types::{Duration, Instant, NmtState, NodeId};
//!
//! let mut heartbeat = Producer::new(NodeId::of::<3>(), Duration::from_millis(100));
//! heartbeat.announce(Instant::ZERO);
//! let frame = heartbeat.poll(Instant::ZERO, NmtState::PreOperational).unwrap();
//! assert_eq!((frame.id().raw(), frame.data()), (0x703, &[0x7F][..]));
//! assert!(heartbeat.poll(Instant::ZERO, NmtState::PreOperational).is_none());
//! let next = heartbeat.deadline().unwrap(); // wait until then
//! assert_eq!((next.as_micros(), heartbeat.poll(next, NmtState::Operational).is_some()), (100_000, true));
//! ```
//!
//! The page of each module has an example of its service.
//!
//! # Modules
//!
//! A module uses only modules above it in this table.
//!
//! | module | contents |
//! | --- | --- |
//! | [`types`] | frames, identifiers, instants: words of the field without behaviour; canonical forms of states |
//! | [`link`] | ports, adapters of drivers, filters, transmit queue, bit timing, recovery from bus-off, budgets, stamps |
//! | [`od`] | object dictionary: declarations, data types, access |
//! | [`nmt`] | network management: NMT state machine, commands, guards |
//! | [`heartbeat`], [`sync`], [`emcy`] | producers and consumers of heartbeats, SYNC, emergencies |
//! | [`sdo`] | SDO server and client |
//! | [`pdo`] | receive and transmit PDOs, their declaration, sequences of commands |
//! | [`store`] | parameters that outlive a reset |
//! | [`boot`] | boot-up of the network by its master |
//! | [`node`] | the services put together: the slave, the trait of a device; parts for nodes of another kind |
//! | [`runner`] | async shell: tasks of a node, handle of the application |
//! | [`prelude`] | names for a device, its application and its `main` |
//! | `mock` | mock board, for tests and examples (feature `mock`) |
//!
//! # Features
//!
//! - `mock`: the module `mock`. It needs an allocator; the rest of the crate has no heap.
//! - `defmt`: every public type implements `defmt::Format`.
//! - `critical-section`: atomics of chips without compare-and-swap, such as Cortex-M0, by critical sections. The image needs an
//!   implementation of the package `critical-section`.
//!
//! # Limits
//!
//! - Identifiers have 11 bits. Remote frames, node guarding, TIME (1012h), multiplex PDOs, LSS and CAN FD are not part of it.
//! - A [`node::CanopenSlave`] has no SDO client, does not produce SYNC, and has no parameter store (1010h, 1011h). The
//!   services for these are here. It receives emergencies of other nodes as [`node::Event::Frame`], without object 1028h.
//! - A device has at most two SDO servers, and 512 PDOs in each direction.
//! - All tasks of a node run in one executor.
//! - A chip without compare-and-swap needs the feature `critical-section`.
//!
//! Related crates: [`async-canopen-derive`](https://docs.rs/async-canopen-derive),
//! [`async-canopen-eds`](https://docs.rs/async-canopen-eds), [`ecss-can`](https://docs.rs/ecss-can),
//! [`can-twin`](https://docs.rs/can-twin).

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "mock")]
extern crate alloc;
// The derive macros name this crate from outside, also in here.
extern crate self as async_canopen;

pub mod boot;
pub mod emcy;
pub mod heartbeat;
pub mod link;
#[cfg(feature = "mock")]
pub mod mock;
pub mod nmt;
pub mod node;
pub mod od;
pub mod pdo;
pub mod prelude;
pub mod runner;
pub mod sdo;
pub mod store;
pub mod sync;
pub mod types;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
