//! Words of the field: those of [`async_canopen::types`], and spacecraft time.
//!
//! [`Scet`] is the time of the spacecraft, the same for all nodes. An [`Instant`] is a time of one node.
//!
//! ```
//! use ecss_can::types::{Duration, Scet};
//!
//! let scet = Scet::new(10, 1 << 23).unwrap(); // 10.5 s
//! assert_eq!(scet.plus(Duration::from_millis(500)), Scet::new(11, 0).unwrap());
//! ```
//!
//! # Limits
//!
//! - Spacecraft time wraps after 2^32 s, so two such times have no total order.

mod fine_scet;
mod scet;
mod utc;

pub use async_canopen::types::*;
pub use fine_scet::FineScet;
pub use scet::Scet;
pub use utc::{Utc, UtcRelation};
