//! Bit timing of bxCAN with the clocks of all boards.

mod controller;

pub use controller::ControllerTiming;
use ecss_can::link::bit_timing::{BitTiming, Hertz, Limits, Network, Range};

use crate::clocks;

/// Clock of the CAN controllers: APB1.
pub const PCLK1: Hertz = Hertz(clocks::PCLK1);

/// Range of the fields of CAN_BTR: BRP, TS1, TS2, SJW (RM0090 32.9.2).
pub const LIMITS: Limits = Limits {
    prescaler: Range::new(1, 1024),
    segment1: Range::new(1, 16),
    segment2: Range::new(1, 8),
    jump_width: 4,
};

/// Returns the bit timing of both CAN controllers for a network. Evaluated as a constant, a network without bit timing
/// fails the build with the reason.
///
/// # Panics
/// When there is no bit timing.
pub const fn bit_timing(network: &Network) -> ControllerTiming {
    ControllerTiming::new(&option(network))
}

const fn option(network: &Network) -> BitTiming {
    match BitTiming::new(&LIMITS, PCLK1, network) {
        Ok(timing) => timing,
        Err(error) => panic!("{}", error.message().as_str()),
    }
}

#[cfg(test)]
mod tests {
    use ecss_can::link::bit_timing::{BitRate, Metres, PartsPerMillion, Permille};

    use super::*;

    /// Given networks of one bit rate and of several, then each has its own time quanta and sample point, in the registers of
    /// bxCAN at 42 MHz: prescaler, TS1, TS2, SJW. They are those of common calculators for the rates, and calculated by hand
    /// for the two networks with worse oscillators.
    ///
    /// Verifies: ECSS 5.4.3a, 5.4.2a, 5.4.2b, 5.4.3c, 5.4.3d
    /// Notices: ECSS 5.4.3a: the clock behind the time quanta is half of what it is.
    /// Notices: ECSS 5.4.3a: the jump width that a network asks for is not taken.
    /// Notices: ECSS 5.4.3a: prescalers above 64 are refused.
    /// Notices: ECSS 5.4.2b: a bus is offered at 1 Mbit/s and 500 kbit/s, and not at 125 kbit/s.
    /// Notices: ECSS 5.4.3d: the jump width is 4 whatever the phase segments are.
    #[test]
    fn time_quanta_and_sample_point_follow_the_network() {
        let crystals = |bit_rate| Network {
            bit_rate,
            length: Metres(20),
            node_delay: Network::NODE_DELAY,
            oscillator_tolerance: PartsPerMillion(1_000),
            jump_width: Network::JUMP_WIDTH,
        };
        let worse = |ppm| Network { oscillator_tolerance: PartsPerMillion(ppm), ..crystals(BitRate::MBIT_1) };
        for (network, registers, sample_point) in [
            (crystals(BitRate::MBIT_1), [3, 11, 2, 1], 857),
            (worse(4_000), [3, 11, 2, 2], 857),
            (worse(7_000), [2, 16, 4, 4], 809),
            (crystals(BitRate::KBIT_500), [6, 11, 2, 1], 857),
            (crystals(BitRate::KBIT_250), [12, 11, 2, 1], 857),
            (crystals(BitRate::KBIT_125), [21, 13, 2, 1], 875),
            (crystals(BitRate::KBIT_10), [280, 12, 2, 1], 866),
            // Phase segments of 2, and a jump width of 1 where it is asked for.
            (worse(3_000), [3, 11, 2, 2], 857),
            (Network { jump_width: 1, ..worse(3_000) }, [3, 11, 2, 1], 857),
        ] {
            let timing = option(&network);
            let segments = [timing.segment1(), timing.segment2(), timing.jump_width()].map(u16::from);
            let [ts1, ts2, sjw] = segments;
            assert_eq!([timing.prescaler(), ts1, ts2, sjw], registers, "{network:?}");
            assert_eq!(timing.sample_point(), Permille(sample_point), "{network:?}");
        }
    }

    /// Given a line of 40 m and oscillators of 0.1 %, then bxCAN at 42 MHz has a timing for each bit rate of the standard, and a bit
    /// has exactly the clocks of this rate: 42 MHz divided by the rate, by hand.
    ///
    /// Verifies: ECSS 5.4.2a.1, 5.4.2a.2, 5.4.2a.3
    /// Notices: ECSS 5.4.2a.1: prescalers above 3 are refused, and only 1 Mbit/s has a timing.
    /// Notices: ECSS 5.4.2a.3: prescalers above 16 are refused, and 125 kbit/s has no timing.
    #[test]
    fn each_rate_of_the_standard_has_its_clocks_in_a_bit() {
        for (bit_rate, clocks) in [
            (BitRate::MBIT_1, 42),
            (BitRate::KBIT_500, 84),
            (BitRate::KBIT_250, 168),
            (BitRate::KBIT_125, 336),
        ] {
            let timing = option(&Network {
                bit_rate,
                length: Metres(40),
                node_delay: Network::NODE_DELAY,
                oscillator_tolerance: PartsPerMillion(1_000),
                jump_width: Network::JUMP_WIDTH,
            });
            assert_eq!(timing.prescaler() * u16::from(timing.quanta()), clocks, "{} bit/s", bit_rate.get());
        }
    }
}
