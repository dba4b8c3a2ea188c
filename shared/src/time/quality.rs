//! Source of the time, and its error bound.

use super::estimator::{units, variance};
use crate::types::Scet;

/// Source of the last time. Object 2015h has its byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TimeSource {
    /// The clock was never set.
    #[default]
    None,
    /// A command set the clock: an SDO, or the application.
    Command,
    /// A SYNC that the capture unit stamped.
    Capture,
    /// A SYNC that was stamped in the interrupt.
    Interrupt,
    /// The plain protocol (ECSS 7.2.2): the time of sending, applied at reception.
    Reception,
}

impl TimeSource {
    /// Variance of one pair, without the quantum of what was sent.
    pub(super) const fn variance(self) -> i64 {
        match self {
            TimeSource::Capture => variance(7),
            TimeSource::Interrupt => variance(500),
            TimeSource::Reception => variance(100_000),
            TimeSource::None | TimeSource::Command => variance(1_000_000),
        }
    }

    /// Most that a pair is off, units of 2^-32 s, without the quantum of what was sent: the stamps of producer and
    /// consumer.
    pub(super) const fn error(self) -> i64 {
        let ns = match self {
            // Two edges and two roundings of a timer of 84 MHz, and 200 ppm of the rest of a SYNC.
            TimeSource::Capture => 36,
            // Latency of an interrupt, at either end.
            TimeSource::Interrupt => 7_000,
            TimeSource::Reception => 300_000,
            TimeSource::None | TimeSource::Command => 5_000_000,
        };
        units(ns)
    }

    /// Weight of unexpected pairs in a row that are no outliers: two on one side, or four, or at the latest the
    /// seventh.
    pub(super) const fn outliers(self) -> i8 {
        if matches!(self, TimeSource::Capture) { 3 } else { 7 }
    }

    /// Part of the error that is the same in each pair, nanoseconds: delays that are not corrected exactly.
    pub(super) const fn systematic(self) -> u32 {
        match self {
            TimeSource::Capture => 30,
            TimeSource::Interrupt => 1_500,
            TimeSource::Reception => 200_000,
            TimeSource::None | TimeSource::Command => 0,
        }
    }
}

/// Step of the clock: it was set instead of steered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Step {
    /// Time of the clock before the step.
    pub from: Scet,
    /// Time of the clock at the same instant, after the step.
    pub to: Scet,
}

/// Quality of the clock of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Quality {
    /// Largest expected error against the spacecraft time, in nanoseconds. `u32::MAX` if it is larger or unknown.
    pub bound_ns: u32,
    /// Source of the last time.
    pub source: TimeSource,
    /// Time since then, in milliseconds. It stays at its maximum.
    pub age_ms: u32,
    /// Rate of spacecraft time against the clock of this node, in 10^-9. Positive if spacecraft time is faster.
    pub rate_ppb: i32,
    /// Number of steps since power-on. It wraps.
    pub steps: u16,
    /// Number of spacecraft times refused since power-on because they did not agree with the others. It wraps.
    pub refused: u16,
}
