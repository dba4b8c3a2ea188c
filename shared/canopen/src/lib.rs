//! Services of CANopen (CiA 301, CiA 302-2) for nodes without an operating system and without a heap.
//!
//! The crate is *sans-IO*: each service is a plain struct without input or output of its own. It takes frames and the
//! time, and returns frames and actions. So it runs on any CAN controller and any executor, and in tests without
//! either. The crate `ecss-can` builds the nodes of ECSS-E-ST-50-15C from it: slaves and masters on two buses.
//!
//! # A tour
//!
//! A device is a struct of objects. The derive macro makes its dictionary, which an SDO server serves. A producer gives
//! the heartbeat when it is due.
//!
//! ```
//! use async_canopen::heartbeat::Producer;
//! use async_canopen::od::checked::find;
//! use async_canopen::od::{ObjectAccess, Objects, Transfer};
//! use async_canopen::sdo::Server;
//! use async_canopen::types::{AbortCode, Address, Duration, Instant, NmtState, NodeId};
//!
//! /// A heater.
//! #[derive(Objects)]
//! struct Heater {
//!     /// Set point in units of 0.1 °C
//!     #[object(0x6000, rw, low = -400, high = 850, default = 200)]
//!     setpoint: i16,
//! }
//!
//! // A node that has more than numbers and strings also passes on parts of a DOMAIN.
//! impl ObjectAccess for Heater {
//!     fn upload(&mut self, at: Address) -> Result<Transfer, AbortCode> {
//!         find(self, at)?.upload()
//!     }
//!     fn read(&mut self, at: Address, offset: usize, into: &mut [u8]) -> Result<usize, AbortCode> {
//!         Ok(find(self, at)?.read(offset, into))
//!     }
//!     fn download(&mut self, at: Address, size: Option<usize>) -> Result<Transfer, AbortCode> {
//!         find(self, at)?.download(size)
//!     }
//!     fn write(&mut self, at: Address, value: &[u8]) -> Result<(), AbortCode> {
//!         async_canopen::od::checked::write(self, at, value)
//!     }
//!     fn write_part(&mut self, _: Address, _: usize, _: &[u8]) -> Result<(), AbortCode> {
//!         Err(AbortCode::UnsupportedAccess)
//!     }
//!     fn finish(&mut self, _: Address, _: usize) -> Result<(), AbortCode> {
//!         Err(AbortCode::UnsupportedAccess)
//!     }
//!     fn cancel(&mut self, _: Address) {}
//! }
//!
//! let mut heater = Heater::default();
//! let mut server = Server::new(Duration::from_millis(500));
//! let mut heartbeat = Producer::new(NodeId::of::<3>(), Duration::from_millis(100));
//! let mut now = Instant::ZERO;
//!
//! // A client sets 25.0 °C, and then 90.0 °C, which is too high: 0609 0031h.
//! let mut answers = Vec::new(); // send them to 580h + Node-ID
//! for tenths in [250_u16, 900] {
//!     let [low, high] = tenths.to_le_bytes();
//!     server.on_request(&[0x2B, 0x00, 0x60, 0, low, high, 0, 0], now, &mut heater, &mut |answer| answers.push(answer));
//! }
//! assert_eq!(answers, [[0x60, 0x00, 0x60, 0, 0, 0, 0, 0], [0x80, 0x00, 0x60, 0, 0x31, 0x00, 0x09, 0x06]]);
//! assert_eq!(heater.setpoint, 250);
//!
//! heartbeat.announce(now);
//! let frame = heartbeat.poll(now, NmtState::PreOperational).unwrap();
//! assert_eq!((frame.id().raw(), frame.data()), (0x703, &[0x7F][..]));
//! assert!(heartbeat.poll(now, NmtState::PreOperational).is_none());
//! now = heartbeat.deadline().unwrap(); // wait until then
//! assert_eq!((now.as_micros(), heartbeat.poll(now, NmtState::Operational).is_some()), (100_000, true));
//! ```
//!
//! # Modules
//!
//! A module uses only modules above it in this table.
//!
//! | module | contents |
//! | --- | --- |
//! | [`types`] | frames, identifiers, instants, time codes: words of the field without behaviour; canonical forms of states |
//! | [`link`] | ports, filters, transmit queue, bit timing, budgets, stamps |
//! | [`od`] | object dictionary: declarations, data types, access |
//! | [`nmt`] | network management: NMT state machine, commands, guards |
//! | [`heartbeat`], [`sync`], [`emcy`] | producers and consumers of heartbeats, SYNC, emergencies |
//! | [`sdo`] | SDO server and client |
//! | [`pdo`] | receive and transmit PDOs, their declaration, sequences of commands |
//! | [`store`] | parameters that outlive a reset |
//! | [`boot`] | boot-up of the network by its master |
//!
//! # Features
//!
//! - `defmt`: every public type implements `defmt::Format`.
//! - `embedded-can`: [`link::adapter`] makes a port of any driver that implements `embedded_can::nb::Can`.
//!
//! # Limits
//!
//! - Identifiers have 11 bits. Remote frames, CAN FD and LSS are not part of it.
//! - A whole node and its tasks are in `ecss-can`: `#[objects(device)]` and the trait `Device` are of that crate.

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
