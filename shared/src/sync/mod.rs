//! SYNC object: producer, consumer, messages (CiA 301 7.2.5, ECSS 6.3, 6.9).

mod consumer;
mod objects;
mod producer;

pub use consumer::{Consumer, UnexpectedLength};
pub use objects::SyncObjects;
pub use producer::{Config, Producer};

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
