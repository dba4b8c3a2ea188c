//! Messages of a bus, and the time that they occupy it.

use std::time::Duration;

/// Bits of an 11-bit data frame that are subject to stuffing, without data: SOF, identifier, RTR, IDE, r0, DLC, CRC
/// sequence.
const STUFFED: u64 = 34;
/// Bits of fixed form: CRC delimiter, ACK slot and delimiter, EOF, and the intermission behind it.
const FIXED: u64 = 13;

/// A message: frames of one COB-ID by one sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message {
    /// COB-ID, 11 bits: its priority, 0 is the highest.
    pub id: u16,
    /// Data bytes, `0..=8`.
    pub bytes: u8,
    /// Period, or shortest time between two releases. Above zero.
    pub period: Duration,
    /// Longest time from the event to the release of its frame in the queue of the sender.
    pub jitter: Duration,
    /// Longest time from the event to the end of the frame.
    pub deadline: Duration,
    /// Index of the message whose reception is the event. Response time and deadline then count from the event of that one, and
    /// its response time is added to the jitter.
    pub after: Option<usize>,
}

impl Message {
    /// Longest time on the bus, stuff bits and intermission included, in bits (Davis et al. 2007):
    /// `34 + 8 s + 13 + (34 + 8 s - 1) / 4`.
    pub fn longest_bits(&self) -> u64 {
        let stuffed = STUFFED + 8 * u64::from(self.bytes);
        stuffed + FIXED + (stuffed - 1) / 4
    }
}

/// Errors on the bus in an interval, each of which destroys a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Errors {
    /// Number of errors that may follow each other immediately.
    pub burst: u64,
    /// Beyond the burst: the shortest time between two errors. `None`: no error but those of the burst.
    pub interval: Option<Duration>,
}

impl Errors {
    /// No errors.
    pub const NONE: Errors = Errors { burst: 0, interval: None };

    /// The most errors in an interval of `span` nanoseconds (Tindell and Burns 1994): `burst + ceil(span / interval) -
    /// 1`, where the first interval also begins with an error if there is no burst.
    pub(crate) fn within(&self, span: u64) -> u64 {
        let residual = self.interval.map_or(0, |interval| span.div_ceil(nanos(interval)).max(1) - 1);
        self.burst.max(self.interval.is_some().into()) + residual
    }
}

/// A bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Network {
    /// Bits per second, above zero.
    pub bit_rate: u32,
    /// Errors that response times must allow for.
    pub errors: Errors,
}

impl Network {
    /// Returns the duration of `bits` bits in nanoseconds, rounded up.
    pub(crate) fn bits(&self, bits: u64) -> u64 {
        (bits * 1_000_000_000).div_ceil(u64::from(self.bit_rate))
    }

    /// Longest time of a message on the bus, intermission included.
    pub fn transmission(&self, message: &Message) -> Duration {
        Duration::from_nanos(self.bits(message.longest_bits()))
    }

    /// Returns the greatest share of the bus that these messages use, without errors: 1 is all of it.
    pub fn load(&self, messages: &[Message]) -> f64 {
        let share =
            |message: &Message| self.transmission(message).as_secs_f64() / message.period.as_secs_f64();
        messages.iter().map(share).sum()
    }
}

/// Returns whole nanoseconds, up to 584 years.
pub(crate) fn nanos(span: Duration) -> u64 {
    u64::try_from(span.as_nanos()).unwrap_or(u64::MAX)
}
