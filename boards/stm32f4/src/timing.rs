//! Bit timing of bxCAN behind the clocks of all boards.

use ecss_can::link::bit_timing::{BitTiming, Hertz, Limits, Network, Range};

use crate::clocks;

/// Clock of the CAN controllers: APB1.
pub const PCLK1: Hertz = Hertz(clocks::PCLK1);

/// What CAN_BTR can be set to: BRP, TS1, TS2, SJW (RM0090 32.9.2).
pub const LIMITS: Limits = Limits {
    prescaler: Range::new(1, 1024),
    segment1: Range::new(1, 16),
    segment2: Range::new(1, 8),
    jump_width: 4,
};

/// The setting of both CAN controllers for a network. Evaluated as a constant, a network without bit timing fails the
/// build with the reason.
///
/// # Panics
/// When there is no bit timing.
pub const fn bit_timing(network: &Network) -> BitTiming {
    match BitTiming::new(&LIMITS, PCLK1, network) {
        Ok(timing) => timing,
        Err(error) => panic!("{}", error.message().as_str()),
    }
}
