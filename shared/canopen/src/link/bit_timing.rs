//! Bit timing of a CAN controller, computed by constants so that an impossible one stops the build.
//!
//! The *bit timing* divides a bit into time quanta (tq) and places the sample point. It limits the length of the
//! bus and the tolerance of the oscillators.
//!
//! ```text
//! | SYNC | PROP_SEG           | PHASE_SEG1 | PHASE_SEG2 |
//! | 1 tq | TS1                             ^ TS2        |
//!                                          sample point
//! ```
//!
//! The method is that of a paper (iCC 2012): of all options, take the one with the longest propagation segment
//! that meets the oscillator tolerance. An option is a prescaler and the lengths of three segments. It must
//!
//! - give the bit rate exactly, with 8 to 25 time quanta in a bit (ISO 11898-1),
//! - have PHASE_SEG2 = max(PHASE_SEG1, information processing time of 2 tq) (ISO 11898-1),
//! - have SJW = min(4, PHASE_SEG1), or less where the network asks for less,
//! - have the sample point where CiA 301 places it for this bit rate,
//! - fit the registers of the controller, its [`Limits`].
//!
//! With N time quanta in a bit, oscillators may deviate by `df` in either direction, where
//!
//! ```text
//! df <= SJW / (20 N)                                            ten bits from edge to edge, resynchronised
//! df <= min(PHASE_SEG1, PHASE_SEG2) / (2 (13 N - PHASE_SEG2))   thirteen bits after an error flag
//! ```
//!
//! The propagation segment must hold twice the delay between any two nodes: the line and both nodes. [`Limits`] has
//! an example.

mod error;

pub use error::{BitTimingError, ErrorText};

use crate::types::Duration;

/// Frequency in Hz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Hertz(pub u32);

/// Length in metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Metres(pub u16);

/// Time in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nanoseconds(pub u32);

/// Relative error in parts per million, in either direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PartsPerMillion(pub u32);

/// Share of the bit time, in thousandths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Permille(pub u16);

/// Bit rate of high-speed CAN: 10 kbit/s to 1 Mbit/s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BitRate(u32);

impl BitRate {
    /// 1 Mbit/s, which every node supports.
    pub const MBIT_1: BitRate = BitRate(1_000_000);
    /// 500 kbit/s.
    pub const KBIT_500: BitRate = BitRate(500_000);
    /// 250 kbit/s.
    pub const KBIT_250: BitRate = BitRate(250_000);
    /// 125 kbit/s.
    pub const KBIT_125: BitRate = BitRate(125_000);
    /// 50 kbit/s (CiA 301).
    pub const KBIT_50: BitRate = BitRate(50_000);
    /// 20 kbit/s (CiA 301).
    pub const KBIT_20: BitRate = BitRate(20_000);
    /// 10 kbit/s (CiA 301).
    pub const KBIT_10: BitRate = BitRate(10_000);

    /// Makes a bit rate. `None` outside 10,000 to 1,000,000 bit/s.
    pub const fn new(bits_per_second: u32) -> Option<BitRate> {
        match bits_per_second {
            10_000..=1_000_000 => Some(BitRate(bits_per_second)),
            _ => None,
        }
    }

    /// Returns the rate in bit/s.
    pub const fn get(self) -> u32 {
        self.0
    }

    /// Returns the time that `bits` take, `0..=4_000_000` of them, rounded up. The rate counts in whole kbit/s,
    /// rounded down.
    pub const fn span(self, bits: u32) -> Duration {
        Duration::from_micros((bits * 1_000).div_ceil(self.0 / 1_000) as u64)
    }

    /// Returns the first and the last place of the sample point that interoperates (CiA 301 5.4, table of bit
    /// rates).
    pub(crate) const fn sample_points(self) -> (Permille, Permille) {
        (Permille(if self.0 >= 800_000 { 750 } else { 850 }), Permille(900))
    }
}

/// Properties of a network that decide the bit timing of all its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Network {
    /// Bit rate of both buses.
    pub bit_rate: BitRate,
    /// Length of the line between the two nodes that are farthest apart.
    pub length: Metres,
    /// Delay from CAN_TX of one controller to CAN_RX of another one: both transceivers, without the line.
    pub node_delay: Nanoseconds,
    /// Tolerance of the worst oscillator of any node.
    pub oscillator_tolerance: PartsPerMillion,
    /// Greatest SJW, time quanta, `1..=4`. An option takes min(this, PHASE_SEG1). Zero counts as 1, and
    /// more than 4 as 4. A shorter SJW lets nodes follow a disturbed edge less far and needs better oscillators.
    pub jump_width: u8,
}

impl Network {
    /// Node delay with common transceivers, with a reserve: an SN65HVD230 takes at most 135 ns.
    pub const NODE_DELAY: Nanoseconds = Nanoseconds(150);

    /// Greatest SJW that the standard allows.
    pub const JUMP_WIDTH: u8 = 4;

    /// Delay of a twisted pair, per metre.
    pub const LINE_DELAY: Nanoseconds = Nanoseconds(5);

    /// Returns the delay in one direction between the two nodes that are farthest apart.
    pub const fn longest_delay(&self) -> Nanoseconds {
        Nanoseconds(self.propagation().0 / 2)
    }

    /// Returns the delay there and back between the two nodes that are farthest apart.
    pub const fn propagation(&self) -> Nanoseconds {
        let line = self.length.0 as u32 * Self::LINE_DELAY.0;
        Nanoseconds(line.saturating_add(self.node_delay.0).saturating_mul(2))
    }
}

/// First and last value that a field of a register can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range {
    /// Least value of the field.
    pub first: u16,
    /// Greatest value of the field.
    pub last: u16,
}

impl Range {
    /// Makes the range from `first` to `last`, both included.
    pub const fn new(first: u16, last: u16) -> Range {
        Range { first, last }
    }

    const fn contains(self, value: u16) -> bool {
        self.first <= value && value <= self.last
    }

    /// Returns the distance of a value from the range, zero within it.
    const fn distance(self, value: u16) -> u16 {
        if value < self.first { self.first - value } else { value.saturating_sub(self.last) }
    }
}

/// Ranges of the timing registers of a controller. Those of FDCAN, for example:
///
/// ```
/// use async_canopen::link::bit_timing::{
///     BitRate, BitTiming, Hertz, Limits, Metres, Network, PartsPerMillion, Range,
/// };
///
/// const FDCAN: Limits = Limits {
///     prescaler: Range::new(1, 512),
///     segment1: Range::new(2, 256),
///     segment2: Range::new(2, 128),
///     jump_width: 128,
/// };
/// const NETWORK: Network = Network {
///     bit_rate: BitRate::MBIT_1,
///     length: Metres(40),
///     node_delay: Network::NODE_DELAY,
///     oscillator_tolerance: PartsPerMillion(1_000),
///     jump_width: Network::JUMP_WIDTH,
/// };
/// let timing = BitTiming::new(&FDCAN, Hertz(80_000_000), &NETWORK).unwrap();
/// assert_eq!((timing.prescaler(), timing.quanta()), (4, 20));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Clock cycles in a time quantum.
    pub prescaler: Range,
    /// Time quanta from the synchronisation segment to the sample point.
    pub segment1: Range,
    /// Time quanta after the sample point.
    pub segment2: Range,
    /// Greatest number of time quanta by which one resynchronisation moves.
    pub jump_width: u16,
}

/// Fewest and most time quanta to a bit (ISO 11898-1).
const QUANTA: (u8, u8) = (8, 25);
/// Time quanta that a controller may need between sample point and next bit (ISO 11898-1).
const INFORMATION_PROCESSING: u8 = 2;
/// Longest PHASE_SEG1 (ISO 11898-1).
const PHASE: u8 = 8;

/// Bit timing for the registers of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BitTiming {
    prescaler: u16,
    propagation: u8,
    phase1: u8,
    phase2: u8,
    jump_width: u8,
    bit_rate: BitRate,
}

impl BitTiming {
    /// Returns the bit rate that the timing was computed for.
    pub const fn bit_rate(&self) -> BitRate {
        self.bit_rate
    }

    /// Finds the option with the longest propagation segment that meets the oscillator tolerance.
    /// Of equal options it takes the one with more tolerance. `clock` drives the controller.
    ///
    /// # Errors
    /// [`BitTimingError`]: the first constraint that no option meets.
    pub const fn new(limits: &Limits, clock: Hertz, network: &Network) -> Result<BitTiming, BitTimingError> {
        let bit_rate = network.bit_rate;
        let mut outcome = Err(BitTimingError::Prescaler { clock, bit_rate, allowed: limits.prescaler });
        let mut quanta = QUANTA.0;
        while quanta <= QUANTA.1 {
            if let Some(prescaler) = prescaler(clock, bit_rate, quanta, limits.prescaler) {
                let mut phase1 = 1;
                while let Some(option) = Self::option(network, prescaler, quanta, phase1, limits) {
                    outcome = better(outcome, option.meets(network, limits.segment1));
                    phase1 += 1;
                }
            }
            quanta += 1;
        }
        outcome
    }

    /// `None` when the phase segments are too long for the controller or leave no propagation segment.
    const fn option(
        network: &Network,
        prescaler: u16,
        quanta: u8,
        phase1: u8,
        limits: &Limits,
    ) -> Option<BitTiming> {
        let phase2 = if phase1 > INFORMATION_PROCESSING { phase1 } else { INFORMATION_PROCESSING };
        // A controller whose segment 2 cannot be as short needs that time.
        let least = limits.segment2.first;
        let phase2 = if least > phase2 as u16 && least <= QUANTA.1 as u16 { least as u8 } else { phase2 };
        if phase1 > PHASE || !limits.segment2.contains(phase2 as u16) || quanta < 2 + phase1 + phase2 {
            return None;
        }
        let Network { bit_rate, jump_width, .. } = *network;
        let longest = if jump_width < Network::JUMP_WIDTH { jump_width } else { Network::JUMP_WIDTH };
        let longest = if longest == 0 { 1 } else { longest };
        let longest = if limits.jump_width < longest as u16 { limits.jump_width as u8 } else { longest };
        let jump_width = if phase1 < longest { phase1 } else { longest };
        let propagation = quanta - 1 - phase1 - phase2;
        Some(BitTiming { prescaler, propagation, phase1, phase2, jump_width, bit_rate })
    }

    /// The option, unless it breaks a constraint; the errors are in the order of [`BitTimingError`].
    const fn meets(self, network: &Network, segment1: Range) -> Result<BitTiming, BitTimingError> {
        let (first, last) = self.bit_rate.sample_points();
        let thousandths = (self.quanta() - self.phase2) as u16 * 1000;
        let quanta = self.quanta() as u16;
        if thousandths < first.0 * quanta || thousandths > last.0 * quanta {
            return Err(BitTimingError::SamplePoint { place: self.sample_point(), first, last });
        }
        if !segment1.contains(self.segment1() as u16) {
            return Err(BitTimingError::Segment1 { needed: self.segment1(), allowed: segment1 });
        }
        let (needed, available) = (network.propagation(), self.propagation());
        if available.0 < needed.0 {
            return Err(BitTimingError::Propagation { needed, available });
        }
        let (needed, available) = (network.oscillator_tolerance, self.oscillator_tolerance());
        if available.0 < needed.0 {
            return Err(BitTimingError::Tolerance { needed, available });
        }
        Ok(self)
    }

    /// Returns the clock cycles in a time quantum.
    pub const fn prescaler(&self) -> u16 {
        self.prescaler
    }

    /// Returns the time quanta from the synchronisation segment to the sample point.
    pub const fn segment1(&self) -> u8 {
        self.propagation + self.phase1
    }

    /// Returns the time quanta after the sample point.
    pub const fn segment2(&self) -> u8 {
        self.phase2
    }

    /// Returns SJW, the greatest number of time quanta by which one resynchronisation moves: `1..=4`.
    pub const fn jump_width(&self) -> u8 {
        self.jump_width
    }

    /// Returns the time quanta in a bit, `8..=25`.
    pub const fn quanta(&self) -> u8 {
        1 + self.propagation + self.phase1 + self.phase2
    }

    /// Returns the place of the sample point, rounded down.
    pub const fn sample_point(&self) -> Permille {
        Permille((self.quanta() - self.phase2) as u16 * 1000 / self.quanta() as u16)
    }

    /// Returns the delay there and back that the propagation segment allows, rounded down.
    pub const fn propagation(&self) -> Nanoseconds {
        let quanta_per_second = self.bit_rate.0 as u64 * self.quanta() as u64;
        Nanoseconds((self.propagation as u64 * 1_000_000_000 / quanta_per_second) as u32)
    }

    /// Returns the tolerance that every oscillator on the bus may have, rounded down.
    pub const fn oscillator_tolerance(&self) -> PartsPerMillion {
        let quanta = self.quanta() as u32;
        let phase = if self.phase1 < self.phase2 { self.phase1 } else { self.phase2 };
        let running = self.jump_width() as u32 * 1_000_000 / (20 * quanta);
        let after_error = phase as u32 * 1_000_000 / (2 * (13 * quanta - self.phase2 as u32));
        PartsPerMillion(if running < after_error { running } else { after_error })
    }

    /// Returns whether it is the better option.
    const fn is_better_than(&self, other: &BitTiming) -> bool {
        // As shares of the bit time, without rounding.
        let mine = self.propagation as u32 * other.quanta() as u32;
        let theirs = other.propagation as u32 * self.quanta() as u32;
        mine > theirs || mine == theirs && self.oscillator_tolerance().0 > other.oscillator_tolerance().0
    }
}

/// Clocks to a time quantum, if a whole number of them gives the bit rate exactly.
const fn prescaler(clock: Hertz, bit_rate: BitRate, quanta: u8, allowed: Range) -> Option<u16> {
    let quanta_per_second = bit_rate.0 * quanta as u32;
    match clock.0 / quanta_per_second {
        prescaler @ 1..=0xFFFF if clock.0.is_multiple_of(quanta_per_second) => {
            if allowed.contains(prescaler as u16) { Some(prescaler as u16) } else { None }
        }
        _ => None,
    }
}

/// The better option, or the error that got further.
const fn better(
    known: Result<BitTiming, BitTimingError>,
    new: Result<BitTiming, BitTimingError>,
) -> Result<BitTiming, BitTimingError> {
    let new_wins = match (&known, &new) {
        (Ok(known), Ok(new)) => new.is_better_than(known),
        (Err(known), Err(new)) => new.is_closer_than(known),
        (_, new) => new.is_ok(),
    };
    if new_wins { new } else { known }
}
