//! Reason why a network has no bit timing, with the figures of the option that comes closest.

use core::fmt;

use super::{BitRate, Hertz, Nanoseconds, PartsPerMillion, Permille, Range};

/// First constraint, in this order, that no option meets. Its figures are those of the option that comes closest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BitTimingError {
    /// No prescaler divides the clock into 8 to 25 time quanta per bit: take another clock.
    Prescaler {
        /// Clock of the controller.
        clock: Hertz,
        /// Bit rate that was requested.
        bit_rate: BitRate,
        /// Prescalers that the controller can be set to.
        allowed: Range,
    },
    /// The sample point lies too early or too late: take another clock.
    SamplePoint {
        /// Nearest place that is possible.
        place: Permille,
        /// Earliest place that the bit rate allows.
        first: Permille,
        /// Latest place that the bit rate allows.
        last: Permille,
    },
    /// The segment before the sample point cannot have the length that is needed: take another clock.
    Segment1 {
        /// Time quanta that are needed.
        needed: u8,
        /// Time quanta that the controller can be set to.
        allowed: Range,
    },
    /// The propagation segment is too short: take a shorter bus, faster transceivers, or a lower bit rate.
    Propagation {
        /// Delay there and back that the network needs.
        needed: Nanoseconds,
        /// Longest delay that any option allows.
        available: Nanoseconds,
    },
    /// Enough propagation leaves phase segments that are too short: take better oscillators or a shorter bus.
    Tolerance {
        /// Tolerance that was requested.
        needed: PartsPerMillion,
        /// Greatest tolerance of any option with enough propagation.
        available: PartsPerMillion,
    },
}

impl BitTimingError {
    /// Returns whether its option came closer to a bit timing.
    pub(super) const fn is_closer_than(&self, other: &BitTimingError) -> bool {
        use BitTimingError::{Propagation, SamplePoint, Segment1, Tolerance};
        match (self, other) {
            (SamplePoint { place, first, last }, SamplePoint { place: other, .. }) => {
                let allowed = Range::new(first.0, last.0);
                allowed.distance(place.0) < allowed.distance(other.0)
            }
            (Segment1 { needed, allowed }, Segment1 { needed: other, .. }) => {
                allowed.distance(*needed as u16) < allowed.distance(*other as u16)
            }
            (Propagation { available, .. }, Propagation { available: other, .. }) => available.0 > other.0,
            (Tolerance { available, .. }, Tolerance { available: other, .. }) => available.0 > other.0,
            _ => self.constraint() > other.constraint(),
        }
    }

    const fn constraint(&self) -> u8 {
        match self {
            BitTimingError::Prescaler { .. } => 0,
            BitTimingError::SamplePoint { .. } => 1,
            BitTimingError::Segment1 { .. } => 2,
            BitTimingError::Propagation { .. } => 3,
            BitTimingError::Tolerance { .. } => 4,
        }
    }

    /// Returns the error in words, also for a build that it stops.
    pub const fn message(&self) -> ErrorText {
        let text = ErrorText::new("no bit timing: ");
        match *self {
            BitTimingError::Prescaler { clock, bit_rate, allowed } => text
                .text("no prescaler of ")
                .range(allowed)
                .text(" makes 8 to 25 time quanta per bit, clock ")
                .number(clock.0)
                .text(" Hz, bit rate ")
                .number(bit_rate.get())
                .text(" bit/s"),
            BitTimingError::SamplePoint { place, first, last } => text
                .text("sample point at ")
                .number(place.0 as u32)
                .text(" per mille of the bit, allowed ")
                .range(Range::new(first.0, last.0)),
            BitTimingError::Segment1 { needed, allowed } => text
                .text("segment 1 of ")
                .number(needed as u32)
                .text(" time quanta needed, allowed ")
                .range(allowed),
            BitTimingError::Propagation { needed, available } => text
                .text("propagation segment of ")
                .number(needed.0)
                .text(" ns needed, ")
                .number(available.0)
                .text(" ns available"),
            BitTimingError::Tolerance { needed, available } => text
                .text("oscillator tolerance of ")
                .number(needed.0)
                .text(" ppm needed, ")
                .number(available.0)
                .text(" ppm available with this propagation"),
        }
    }
}

impl fmt::Display for BitTimingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message().as_str())
    }
}

impl core::error::Error for BitTimingError {}

/// Longest message.
const LENGTH: usize = 192;

/// Line of text that a constant builds, where `core::fmt` cannot be used. At most 192 bytes; what is longer is cut.
#[derive(Clone, Copy, Debug)]
pub struct ErrorText {
    bytes: [u8; LENGTH],
    len: usize,
}

impl ErrorText {
    /// Begins with this text.
    pub const fn new(text: &str) -> ErrorText {
        ErrorText { bytes: [0; LENGTH], len: 0 }.text(text)
    }

    /// Adds a text.
    #[must_use]
    pub const fn text(mut self, text: &str) -> ErrorText {
        let mut n = 0;
        while n < text.len() && self.len < LENGTH {
            self.bytes[self.len] = text.as_bytes()[n];
            self.len += 1;
            n += 1;
        }
        self
    }

    const fn range(self, range: Range) -> ErrorText {
        self.number(range.first as u32).text(" to ").number(range.last as u32)
    }

    /// Adds a number, decimal.
    #[must_use]
    pub const fn number(mut self, number: u32) -> ErrorText {
        if number > 9 {
            self = self.number(number / 10);
        }
        let digit = [b'0' + (number % 10) as u8];
        match core::str::from_utf8(&digit) {
            Ok(digit) => self.text(digit),
            Err(_) => self,
        }
    }

    /// Returns the text, which is ASCII.
    pub const fn as_str(&self) -> &str {
        match core::str::from_utf8(self.bytes.split_at(self.len).0) {
            Ok(text) => text,
            Err(_) => "text cut within a character",
        }
    }
}
