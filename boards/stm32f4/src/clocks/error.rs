//! Reason why an oscillator has no settings of the PLL.

use core::fmt;

use super::{MULTIPLIER, OscillatorKind, PREDIV, VCO_INPUT, VCO_OUTPUT};

/// Reason why an oscillator has no settings of the PLL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockError {
    /// The oscillator is too slow or too fast for the chip: take another one.
    OscillatorRange {
        /// Its frequency in Hz.
        hz: u32,
        /// Its kind, which decides the range.
        kind: OscillatorKind,
    },
    /// This HCLK does not give APB1 42 MHz and its timers 84 MHz: take 168 MHz or 84 MHz.
    Hclk {
        /// HCLK that was requested, in Hz.
        hclk: u32,
    },
    /// No setting gives HCLK exactly: take an oscillator with a whole number of MHz.
    NoPll {
        /// Frequency of the oscillator in Hz.
        hz: u32,
        /// HCLK that was requested, in Hz.
        hclk: u32,
    },
}

impl ClockError {
    /// Returns the error in words, also for a build that it stops.
    pub const fn message(&self) -> ErrorText {
        let text = ErrorText::new("no clocks: ");
        match *self {
            ClockError::OscillatorRange { hz, kind } => {
                let (first, last) = kind.range();
                text.text(match kind {
                    OscillatorKind::Crystal => "crystal of ",
                    OscillatorKind::External => "external clock of ",
                })
                .number(hz)
                .text(" Hz, allowed ")
                .range(first, last)
                .text(" MHz")
            }
            ClockError::Hclk { hclk } => text.text("HCLK of ").number(hclk).text(
                " Hz, allowed 168000000 or 84000000 Hz: bit timing and time stamps need APB1 at 42 MHz and its timers at \
                 84 MHz",
            ),
            ClockError::NoPll { hz, hclk } => text
                .text("oscillator of ")
                .number(hz)
                .text(" Hz does not give HCLK of ")
                .number(hclk)
                .text(" Hz exactly, take a whole number of MHz; PLLM ")
                .range(PREDIV.0 as u32, PREDIV.1 as u32)
                .text(", PLLN ")
                .range(MULTIPLIER.0 as u32, MULTIPLIER.1 as u32)
                .text(", VCO input ")
                .range(VCO_INPUT.0, VCO_INPUT.1)
                .text(" MHz, VCO output ")
                .range(VCO_OUTPUT.0, VCO_OUTPUT.1)
                .text(" MHz"),
        }
    }
}

impl fmt::Display for ClockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message().as_str())
    }
}

impl core::error::Error for ClockError {}

/// Longest message.
const LENGTH: usize = 192;

/// Line of text that a constant builds, where `core::fmt` cannot be used.
#[derive(Clone, Copy, Debug)]
pub struct ErrorText {
    bytes: [u8; LENGTH],
    len: usize,
}

impl ErrorText {
    const fn new(text: &str) -> ErrorText {
        ErrorText { bytes: [0; LENGTH], len: 0 }.text(text)
    }

    const fn text(mut self, text: &str) -> ErrorText {
        let mut n = 0;
        while n < text.len() && self.len < LENGTH {
            self.bytes[self.len] = text.as_bytes()[n];
            self.len += 1;
            n += 1;
        }
        self
    }

    const fn range(self, first: u32, last: u32) -> ErrorText {
        self.number(first).text(" to ").number(last)
    }

    const fn number(mut self, number: u32) -> ErrorText {
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
            Err(_) => "no clocks",
        }
    }
}
