//! SYNC: producer, consumer, message (CiA 301 7.2.5; objects 1005h, 1006h, 1007h, 1019h).
//!
//! A *SYNC* is a message that the master sends periodically. Synchronous PDOs are sent and take effect with it. The
//! time between two SYNCs is the *communication cycle period*. The *synchronous window* after each SYNC limits the
//! time of its PDOs.
//!
//! ```
//! use async_canopen::sync::machine::{Config, Consumer, Producer};
//! use async_canopen::types::{CobId, Duration, Instant};
//!
//! let period = Duration::from_millis(100);
//! let mut producer = Producer::with(Config { id: CobId::SYNC, period, overflow: 10 });
//! producer.start(Instant::ZERO);
//! let at = producer.deadline().unwrap();
//! let frame = producer.poll(at).unwrap();
//!
//! let mut consumer = Consumer::new(10, 5_000); // 1019h, and 1007h in microseconds
//! assert_eq!(consumer.on_sync(&frame, at), Ok(1)); // the counter
//! assert_eq!(consumer.window_end(), at + Duration::from_millis(5));
//! ```
//!
//! # Limits
//!
//! - Only the master produces SYNC.
//! - The period is zero or at least 100 us. The counter ends at 2 to 240, or there is none.
//! - A SYNC of another length than 1019h requires is ignored and reported (EMCY 8240h).

mod config;
mod consumer;
pub mod machine;
mod objects;
mod producer;

pub(crate) use config::Config;
pub(crate) use consumer::{Consumer, UnexpectedLength};
pub use objects::SyncObjects;
pub(crate) use producer::Producer;

use crate::types::{AbortCode, Frame};

/// Highest value of the counter.
const COUNTER_MAX: u8 = 240;
/// Shortest communication cycle period, in microseconds: half the bus for SYNC alone, at 1 Mbit/s.
const SHORTEST_PERIOD: u32 = 100;

/// Returns whether the frame has the length of a SYNC, with or without a counter (CiA 301 7.2.5.3.2).
pub const fn is_sync_length(frame: &Frame) -> bool {
    frame.dlc() <= 1
}

/// Checks a `period`, in microseconds, that a client writes to 1006h. Zero stops the producer.
///
/// # Errors
/// [`AbortCode::ValueTooLow`] for a period below 100 us.
pub const fn check_period(period: u32) -> Result<(), AbortCode> {
    if period != 0 && period < SHORTEST_PERIOD { Err(AbortCode::ValueTooLow) } else { Ok(()) }
}

/// Checks an `overflow` that a client writes to 1019h while 1006h is `period`.
///
/// # Errors
/// [`AbortCode::DeviceState`] if the period is not zero. [`AbortCode::ValueRange`] for 1 and for values above 240.
pub const fn check_overflow(overflow: u8, period: u32) -> Result<(), AbortCode> {
    if period != 0 {
        return Err(AbortCode::DeviceState);
    }
    if overflow == 1 || overflow > COUNTER_MAX { Err(AbortCode::ValueRange) } else { Ok(()) }
}
