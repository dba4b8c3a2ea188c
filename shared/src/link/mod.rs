//! The data link below the protocol: ports, filters, queues, bit timing, stamps.

pub mod bit_timing;
pub mod budget;
pub mod depth;
pub mod one_controller;
mod pattern;
pub mod port;
pub mod queue;
mod stamp;

pub use stamp::{Captured, EDGES, EdgeRing, Miss, Stamp, StampSource};
