//! Data link below the protocol: ports, filters, transmit queues, bit timing, stamps.
//!
//! A *port* is the interface between the protocol and one CAN controller: the trait [`CanPort`](port::CanPort). A
//! *stamp* is the instant at which a frame ended, on the clock of the node. Each frame that waits for its bus has a
//! *lifetime*, after which it is aborted and reported.
//!
//! ```
//! use async_canopen::link::machine::Places;
//! use async_canopen::link::machine::{Outgoing, TxQueue};
//! use async_canopen::types::{CobId, Frame, Instant};
//!
//! let mut queue = TxQueue::<Places<8>>::new();
//! let expires = Instant::from_micros(100_000);
//! for id in [0x283, 0x080, 0x703] {
//!     let frame = Frame::of(CobId::new(id).unwrap(), [0]);
//!     queue.push(Outgoing { frame, expires }).unwrap();
//! }
//! assert_eq!(queue.pop().unwrap().frame.id(), CobId::SYNC); // the lowest COB-ID first
//! assert!(queue.pop().unwrap().is_expired(expires)); // too late for the next one
//! ```
//!
//! | module | contents |
//! | --- | --- |
//! | [`port`] | the trait of a controller, its events, filters, error state |
//! | [`machine`] | transmit queue of a bus, depth of all queues of a node |
//! | [`bit_timing`] | bit timing, computed by constants |
//! | [`budget`] | limit of the frames that a node may send |
//! | [`bus_off`] | recovery of a controller from bus-off |
//! | [`access`] | access of a node to two buses |
//! | [`one_controller`] | one controller behind a transceiver switch |
//! | [`adapter`] | a port over a driver of another project |
//!
//! # Another chip
//!
//! 1. Describe the timing registers as [`Limits`](bit_timing::Limits), and compute a
//!    [`BitTiming`](bit_timing::BitTiming).
//! 2. Implement [`CanPort`](port::CanPort) for each controller. A port starts off the bus.
//!    If there is a driver already, an [`Adapter`](adapter::Adapter) makes a port of it, with limits.
//! 3. For stamps in hardware, let a DMA write the captured edges of CAN_RX into an [`EdgeRing`]. Otherwise use the
//!    stamp of the interrupt.
//!
//! # Limits
//!
//! - A port has 1 to 32 filters. If a node needs more, the last filter admits every frame.
//! - At most [`LATE_RESULTS`](port::LATE_RESULTS) results of transmissions may follow a frame that was received
//!   later.

pub mod access;
pub mod adapter;
pub mod bit_timing;
pub mod budget;
pub mod bus_off;
pub(crate) mod depth;
pub mod machine;
pub mod one_controller;
mod pattern;
pub mod port;
pub(crate) mod queue;
pub(crate) mod ring;
mod stamp;

pub use stamp::{Captured, EDGES, EdgeRing, Miss, Stamp, StampSource};
