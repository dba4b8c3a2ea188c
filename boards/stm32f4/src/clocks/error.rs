//! Reason why an oscillator has no settings of the PLL.

use core::fmt;

use ecss_can::link::bit_timing::ErrorText;

use super::{MULTIPLIER, OscillatorKind, PREDIV, VCO_INPUT, VCO_OUTPUT};

/// Reason why an oscillator has no settings of the PLL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockError {
    /// The oscillator is too slow or too fast for the chip: use another one.
    OscillatorRange {
        /// Its frequency in Hz.
        hz: u32,
        /// Kind of the oscillator, which determines the range.
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
    /// Returns the error message, also at compile time.
    pub const fn message(&self) -> ErrorText {
        let text = ErrorText::new("no clocks: ");
        match *self {
            ClockError::OscillatorRange { hz, kind } => {
                let (first, last) = kind.range();
                let text = text.text(match kind {
                    OscillatorKind::Crystal => "crystal of ",
                    OscillatorKind::External => "external clock of ",
                });
                range(text.number(hz).text(" Hz, allowed "), first, last).text(" MHz")
            }
            ClockError::Hclk { hclk } => text.text("HCLK of ").number(hclk).text(
                " Hz, allowed 168000000 or 84000000 Hz: bit timing and time stamps need APB1 at 42 MHz and its timers at \
                 84 MHz",
            ),
            ClockError::NoPll { hz, hclk } => {
                let text = text.text("oscillator of ").number(hz).text(" Hz does not give HCLK of ").number(hclk);
                let text = text.text(" Hz exactly, take a whole number of MHz; PLLM ");
                let text = range(text, PREDIV.0 as u32, PREDIV.1 as u32).text(", PLLN ");
                let text = range(text, MULTIPLIER.0 as u32, MULTIPLIER.1 as u32).text(", VCO input ");
                let text = range(text, VCO_INPUT.0, VCO_INPUT.1).text(" MHz, VCO output ");
                range(text, VCO_OUTPUT.0, VCO_OUTPUT.1).text(" MHz")
            }
        }
    }
}

impl fmt::Display for ClockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message().as_str())
    }
}

impl core::error::Error for ClockError {}

/// Appends the least and the greatest allowed value.
const fn range(text: ErrorText, first: u32, last: u32) -> ErrorText {
    text.number(first).text(" to ").number(last)
}
