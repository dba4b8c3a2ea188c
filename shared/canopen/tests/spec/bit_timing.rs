//! Bit timing: published settings, and every setting that there is.
//!
//! Verifies: ECSS 5.4.3b, 5.4.3c

use async_canopen::link::bit_timing::{
    BitRate, BitTiming, BitTimingError, ErrorText, Hertz, Limits, Metres, Nanoseconds, Network,
    PartsPerMillion, Permille, Range,
};
use proptest::prelude::*;

use crate::random::cases;

const MHZ: u32 = 1_000_000;

/// RM0090 32.9.2.
const BXCAN: Limits = Limits {
    prescaler: Range::new(1, 1024),
    segment1: Range::new(1, 16),
    segment2: Range::new(1, 8),
    jump_width: 4,
};

/// NBTP of FDCAN (RM0440 44.4.7).
const FDCAN: Limits = Limits {
    prescaler: Range::new(1, 512),
    segment1: Range::new(2, 256),
    segment2: Range::new(2, 128),
    jump_width: 128,
};

/// One with less of everything.
const NARROW: Limits = Limits {
    prescaler: Range::new(2, 64),
    segment1: Range::new(7, 11),
    segment2: Range::new(3, 4),
    jump_width: 2,
};

fn rate(bits_per_second: u32) -> BitRate {
    BitRate::new(bits_per_second).unwrap()
}

/// A network that leaves the choice to the method: no line, crystals of 0.1 %.
fn desk(bits_per_second: u32) -> Network {
    Network {
        bit_rate: rate(bits_per_second),
        length: Metres(0),
        node_delay: Nanoseconds(0),
        oscillator_tolerance: PartsPerMillion(1_000),
        jump_width: Network::JUMP_WIDTH,
    }
}

/// Time quanta, TS1, TS2, SJW.
fn segments(clock: u32, network: &Network) -> [u8; 4] {
    let timing = BitTiming::new(&BXCAN, Hertz(clock), network).unwrap();
    [timing.quanta(), timing.segment1(), timing.segment2(), timing.jump_width()]
}

/// Verifies: ECSS 5.4.2a, 5.4.2a.1, 5.4.2a.2, 5.4.2a.3, 5.4.2b
///
/// CiA DS 102: 16 time quanta and 87.5 % up to 500 kbit/s, 10 and 80 % at 800 kbit/s, 8 and 75 % at 1 Mbit/s, TS2 2 and
/// SJW 1 throughout, oscillators of 0.1 %. At 8 MHz the two fast rates leave no other choice.
#[test]
fn the_rates_of_cia_get_the_settings_of_cia() {
    for bits_per_second in [10_000, 20_000, 50_000, 125_000, 250_000, 500_000] {
        assert_eq!(segments(16 * MHZ, &desk(bits_per_second)), [16, 13, 2, 1], "{bits_per_second} bit/s");
    }
    assert_eq!(segments(8 * MHZ, &desk(800_000)), [10, 7, 2, 1]);
    assert_eq!(segments(8 * MHZ, &desk(1_000_000)), [8, 5, 2, 1]);
}

/// Bosch, C_CAN user's manual 4.2.1.7: 10 MHz, drivers 50 ns, receivers 30 ns, line 220 ns (44 m), 0.39 %.
///
/// Notices: ECSS 5.4.3b: the delay of the nodes counts in one direction only.
#[test]
fn the_example_of_bosch_at_1_mbit() {
    let network = Network { length: Metres(44), node_delay: Nanoseconds(80), ..desk(1_000_000) };
    assert_eq!(network.propagation(), Nanoseconds(600));
    let timing = BitTiming::new(&BXCAN, Hertz(10 * MHZ), &network).unwrap();
    assert_eq!([timing.segment1(), timing.segment2(), timing.jump_width()], [7, 2, 1]);
    assert_eq!(timing.prescaler(), 1);
    assert_eq!(timing.propagation(), Nanoseconds(600));
    assert_eq!(timing.oscillator_tolerance(), PartsPerMillion(3_906));
}

/// Given a network that asks for a shorter jump width, then the timing has it, with the tolerance that is left: the limit of 13 bits
/// after an error flag, or SJW / (20 N).
///
/// Verifies: ECSS 5.4.3d
/// Notices: ECSS 5.4.3d: a jump width above 4 is taken as it is asked for.
#[test]
fn a_network_may_ask_for_a_shorter_jump_width() {
    let oscillator_tolerance = PartsPerMillion(5_500);
    let timing = |jump_width| {
        let network = Network { jump_width, oscillator_tolerance, ..desk(1_000_000) };
        BitTiming::new(&BXCAN, Hertz(40 * MHZ), &network).unwrap()
    };
    let longest = timing(4).jump_width();
    assert!(longest >= 2, "{longest}");
    for (asked, expected) in [(1, 1), (0, 1), (9, longest)] {
        let timing = timing(asked);
        assert_eq!(timing.jump_width(), expected, "{asked}");
        // SJW / (20 N).
        let limit = u32::from(expected) * 1_000_000 / (20 * u32::from(timing.quanta()));
        assert!(timing.oscillator_tolerance().0 <= limit, "{timing:?}");
    }
    // Registers that hold more than the standard allows: 25 time quanta, phase segments of 5.
    let network = Network { jump_width: 9, oscillator_tolerance: PartsPerMillion(7_000), ..desk(1_000_000) };
    let timing = BitTiming::new(&FDCAN, Hertz(25 * MHZ), &network).unwrap();
    assert_eq!([timing.quanta(), timing.segment1(), timing.segment2(), timing.jump_width()], [25, 19, 5, 4]);
}

/// Given 25 time quanta and oscillators that need phase segments of 3 or 4, when a network asks for each jump width, then the timing has
/// it, up to MIN(4, Phase_Seg1). With a phase segment of 1 it is 1, whatever is asked for.
///
/// Verifies: ECSS 5.4.3d
/// Notices: ECSS 5.4.3d: the jump width is phase segment 1, whatever a shorter one is asked for.
/// Notices: ECSS 5.4.3d: the jump width may be longer than phase segment 1.
#[test]
fn jump_width_is_as_asked_for_up_to_phase_segment_1() {
    let timing = |jump_width, ppm| {
        let oscillator_tolerance = PartsPerMillion(ppm);
        let network = Network { jump_width, oscillator_tolerance, ..desk(1_000_000) };
        let timing = BitTiming::new(&FDCAN, Hertz(25 * MHZ), &network).unwrap();
        [timing.quanta(), timing.segment2(), timing.jump_width()]
    };
    // SJW / (20 N) and phase segment / 2 (13 N - phase segment), both for N = 25.
    for (asked, ppm, phase, expected) in [
        (2, 4_000, 3, 2),
        (3, 4_000, 3, 3),
        (4, 4_000, 3, 3),
        (9, 4_000, 3, 3),
        (3, 6_000, 4, 3),
        (4, 6_000, 4, 4),
    ] {
        assert_eq!(timing(asked, ppm), [25, phase, expected], "{asked} at {ppm} ppm");
    }
    for asked in [1, 2, 3, 4, 9] {
        let network = Network { jump_width: asked, ..desk(1_000_000) };
        assert_eq!(segments(8 * MHZ, &network), [8, 5, 2, 1], "{asked}");
    }
}

/// Given a controller whose phase segment 2 has 4 time quanta at least, when phase segment 1 is shorter, then the jump width is phase
/// segment 1: 20 time quanta of 20 MHz, of which 15 are TS1. Oscillators of 0.3 % need SJW / (20 x 20) with SJW 2, those of 0.55 % SJW 3.
///
/// Verifies: ECSS 5.4.3d
/// Notices: ECSS 5.4.3d: the jump width is that of phase segment 2 where that is longer.
#[test]
fn jump_width_is_at_most_phase_segment_1_if_that_is_shorter() {
    let limits = Limits { segment2: Range::new(4, 8), ..BXCAN };
    for (tolerance, phase_segment_1) in [(1_000, 1), (3_000, 2), (5_500, 3)] {
        let oscillator_tolerance = PartsPerMillion(tolerance);
        let network = Network { jump_width: 4, oscillator_tolerance, ..desk(1_000_000) };
        let timing = BitTiming::new(&limits, Hertz(20 * MHZ), &network).unwrap();
        let found = [timing.quanta(), timing.segment1(), timing.segment2(), timing.jump_width()];
        assert_eq!(found, [20, 15, 4, phase_segment_1], "{tolerance} ppm");
        // 50 ns each: TS1 is the propagation segment and phase segment 1.
        assert_eq!(timing.propagation(), Nanoseconds(50 * (15 - u32::from(phase_segment_1))));
    }
}

/// The same, with oscillators that are just good enough, and with worse ones: the line leaves no longer segments.
#[test]
fn a_tolerance_is_met_when_it_is_equal() {
    let network = |tolerance| Network {
        length: Metres(44),
        node_delay: Nanoseconds(80),
        oscillator_tolerance: PartsPerMillion(tolerance),
        ..desk(1_000_000)
    };
    let timing = BitTiming::new(&BXCAN, Hertz(10 * MHZ), &network(3_906)).unwrap();
    assert_eq!([timing.segment1(), timing.segment2(), timing.jump_width()], [7, 2, 1]);
    assert!(BitTiming::new(&BXCAN, Hertz(10 * MHZ), &network(3_907)).is_err());
}

/// Given each rate of the standard on a line as long as CiA 301 has it for that rate, better and worse oscillators, and clocks of
/// several controllers, then there is a timing, and a bit has exactly the clocks of its rate.
///
/// Verifies: ECSS 5.4.2a, 5.4.2a.1, 5.4.2a.2, 5.4.2a.3
/// Notices: ECSS 5.4.2a: of other rates than 1 Mbit/s none has a timing behind a clock above 48 MHz.
/// Notices: ECSS 5.4.2a.1: 500 kbit/s is refused with oscillators worse than 0.1 %.
/// Notices: ECSS 5.4.2a.2: 250 kbit/s is refused on a line above 100 m.
/// Notices: ECSS 5.4.2a.3: 125 kbit/s is refused on a line above 250 m.
#[test]
fn each_rate_of_the_standard_is_there_on_long_lines_and_behind_each_clock() {
    for (bit_rate, length) in [(BitRate::KBIT_500, 100), (BitRate::KBIT_250, 250), (BitRate::KBIT_125, 500)] {
        for ppm in [100, 1_000, 2_000] {
            for (limits, clock) in [(BXCAN, 36 * MHZ), (BXCAN, 42 * MHZ), (FDCAN, 80 * MHZ)] {
                let network = Network {
                    bit_rate,
                    length: Metres(length),
                    node_delay: Network::NODE_DELAY,
                    oscillator_tolerance: PartsPerMillion(ppm),
                    jump_width: Network::JUMP_WIDTH,
                };
                let timing = BitTiming::new(&limits, Hertz(clock), &network);
                let clocks = timing.map(|timing| u32::from(timing.prescaler()) * u32::from(timing.quanta()));
                assert_eq!(clocks, Ok(clock / bit_rate.get()), "{network:?}");
            }
        }
    }
}

/// What calculators for bxCAN give at the 42 MHz of our boards, as prescaler, TS1 and TS2.
///
/// Verifies: ECSS 5.4.2a, 5.4.2a.1, 5.4.2a.2, 5.4.2a.3, 5.4.3a
#[test]
fn the_settings_at_42_mhz() {
    for (bits_per_second, expected) in [
        (1_000_000, (3, 11, 2, 857)),
        (500_000, (6, 11, 2, 857)),
        (250_000, (12, 11, 2, 857)),
        (125_000, (21, 13, 2, 875)),
    ] {
        let timing = BitTiming::new(&BXCAN, Hertz(42 * MHZ), &desk(bits_per_second)).unwrap();
        let found = (timing.prescaler(), timing.segment1(), timing.segment2(), timing.sample_point().0);
        assert_eq!(found, expected, "{bits_per_second} bit/s");
    }
    // 52.5 clocks to a bit.
    let error = BitTiming::new(&BXCAN, Hertz(42 * MHZ), &desk(800_000)).unwrap_err();
    assert_eq!(
        error,
        BitTimingError::Prescaler {
            clock: Hertz(42 * MHZ),
            bit_rate: rate(800_000),
            allowed: BXCAN.prescaler
        }
    );
}

/// Notices: ECSS 5.4.3c: the option with the least propagation is taken.
///
/// At 42 MHz and 1 Mbit/s 21 time quanta (81.0 %, phase segments of 4) would be finer, but their propagation segment of
/// 12/21 of the bit holds less than the 10/14 of the option chosen.
#[test]
fn more_propagation_wins_over_finer_quanta() {
    let network = Network { length: Metres(40), node_delay: Network::NODE_DELAY, ..desk(1_000_000) };
    let timing = BitTiming::new(&BXCAN, Hertz(42 * MHZ), &network).unwrap();
    assert_eq!(timing.quanta(), 14);
    assert_eq!(timing.propagation(), Nanoseconds(714));
    // Worse oscillators need longer phase segments, and get them as long as the line allows.
    let loose = Network { length: Metres(20), oscillator_tolerance: PartsPerMillion(4_000), ..network };
    assert_eq!(segments(42 * MHZ, &loose), [14, 11, 2, 2]);
    let looser = Network { oscillator_tolerance: PartsPerMillion(7_000), ..loose };
    assert_eq!(segments(42 * MHZ, &looser), [21, 16, 4, 4]);
}

/// 25 time quanta of 12.5 MHz are what segment 1 of bxCAN is too short for: 22 before the sample point are 88 %, 23 are
/// more than 90 %.
///
/// Verifies: ECSS 5.4.3a
/// Notices: ECSS 5.4.3a: 25 time quanta, or the smallest prescaler, are not tried.
/// Notices: ECSS 5.4.3a: segment 2 has 4 time quanta at most.
#[test]
fn another_controller_has_the_settings_of_its_registers() {
    let timing = BitTiming::new(&FDCAN, Hertz(80 * MHZ), &desk(1_000_000)).unwrap();
    assert_eq!([timing.quanta(), timing.segment1(), timing.segment2(), timing.jump_width()], [20, 17, 2, 1]);
    let timing = BitTiming::new(&FDCAN, Hertz(12_500_000), &desk(500_000)).unwrap();
    assert_eq!([timing.quanta(), timing.segment1(), timing.segment2(), timing.jump_width()], [25, 21, 3, 3]);
    // Worse oscillators: phase segments of 5, and the sample point at 80 %.
    let worse = Network { oscillator_tolerance: PartsPerMillion(7_000), ..desk(1_000_000) };
    let timing = BitTiming::new(&FDCAN, Hertz(25 * MHZ), &worse).unwrap();
    assert_eq!([timing.quanta(), timing.segment1(), timing.segment2()], [25, 19, 5]);
    // The least segment 2 is 3, the most SJW 2.
    let timing = BitTiming::new(&NARROW, Hertz(48 * MHZ), &desk(1_000_000)).unwrap();
    assert_eq!([timing.quanta(), timing.segment1(), timing.segment2()], [12, 8, 3]);
    let loose = Network { oscillator_tolerance: PartsPerMillion(4_000), ..desk(1_000_000) };
    let timing = BitTiming::new(&NARROW, Hertz(48 * MHZ), &loose).unwrap();
    assert_eq!(timing.jump_width(), 2);
    let error = BitTiming::new(&NARROW, Hertz(8 * MHZ), &desk(1_000_000)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no bit timing: no prescaler of 2 to 64 makes 8 to 25 time quanta per bit, clock 8000000 Hz, bit rate \
         1000000 bit/s"
    );
}

#[test]
fn the_error_says_what_fails_and_by_how_much() {
    let error = |clock: u32, network: Network| BitTiming::new(&BXCAN, Hertz(clock), &network).unwrap_err();
    // 4 MHz makes 8 time quanta of 500 kbit/s, the last two after the sample point: 75 %.
    assert_eq!(
        error(4 * MHZ, desk(500_000)),
        BitTimingError::SamplePoint { place: Permille(750), first: Permille(850), last: Permille(900) }
    );
    // 12.5 MHz makes 25, of which 85 % or more lie before the sample point: at least 1 + 21.
    assert_eq!(
        error(12_500_000, desk(500_000)),
        BitTimingError::Segment1 { needed: 21, allowed: BXCAN.segment1 }
    );
    // 100 m there and back take 1000 ns.
    assert_eq!(
        error(42 * MHZ, Network { length: Metres(100), ..desk(1_000_000) }),
        BitTimingError::Propagation { needed: Nanoseconds(1_000), available: Nanoseconds(714) }
    );
    // Of 14 time quanta 9 hold 600 ns, which leaves 2 to each phase segment: 2 / (2 (13 x 14 - 2)).
    assert_eq!(
        error(
            42 * MHZ,
            Network { length: Metres(60), oscillator_tolerance: PartsPerMillion(8_000), ..desk(1_000_000) }
        ),
        BitTimingError::Tolerance { needed: PartsPerMillion(8_000), available: PartsPerMillion(5_555) }
    );
}

/// As a failed build shows it.
const MESSAGE: ErrorText = match BitTiming::new(
    &BXCAN,
    Hertz(42_000_000),
    &Network {
        bit_rate: BitRate::new(800_000).unwrap(),
        length: Metres(40),
        node_delay: Network::NODE_DELAY,
        oscillator_tolerance: PartsPerMillion(1_000),
        jump_width: Network::JUMP_WIDTH,
    },
) {
    Err(error) => error.message(),
    Ok(_) => panic!("there are no 52.5 clocks to a bit"),
};

#[test]
fn the_message_is_made_while_compiling() {
    assert_eq!(
        MESSAGE.as_str(),
        "no bit timing: no prescaler of 1 to 1024 makes 8 to 25 time quanta per bit, clock 42000000 Hz, \
         bit rate 800000 bit/s"
    );
    let error = BitTimingError::Tolerance { needed: PartsPerMillion(10), available: PartsPerMillion(9) };
    assert_eq!(
        error.to_string(),
        "no bit timing: oscillator tolerance of 10 ppm needed, 9 ppm available with this propagation"
    );
}

#[test]
fn bit_rates_end_at_those_of_the_standards() {
    assert_eq!(BitRate::new(9_999), None);
    assert_eq!(BitRate::new(1_000_001), None);
    assert_eq!(rate(1_000_000), BitRate::MBIT_1);
}

/// Segment lengths in time quanta, as the texts name them.
#[derive(Clone, Copy, Debug)]
struct Setting {
    bits_per_second: u64,
    propagation: u64,
    phase1: u64,
    phase2: u64,
    jump_width: u64,
}

impl Setting {
    fn quanta(&self) -> u64 {
        1 + self.propagation + self.phase1 + self.phase2
    }

    /// CiA 301, table of bit rates.
    fn samples_in_range(&self) -> bool {
        let earliest = if self.bits_per_second >= 800_000 { 75 } else { 85 };
        let before = 100 * (1 + self.propagation + self.phase1);
        before >= earliest * self.quanta() && before <= 90 * self.quanta()
    }

    /// Both oscillator conditions.
    fn tolerates(&self, ppm: u64) -> bool {
        let running = 20 * self.quanta() * ppm <= self.jump_width * 1_000_000;
        let after_error =
            2 * (13 * self.quanta() - self.phase2) * ppm <= self.phase1.min(self.phase2) * 1_000_000;
        running && after_error
    }

    fn holds(&self, nanoseconds: u64) -> bool {
        self.propagation * 1_000_000_000 >= nanoseconds * self.bits_per_second * self.quanta()
    }
}

/// Every way to set prescaler, segments and SJW that gives the bit rate exactly; segment 1 as long as it likes.
fn settings(limits: &Limits, clock: u64, bits_per_second: u64) -> Vec<Setting> {
    let mut found = Vec::new();
    let Range { first, last } = limits.prescaler;
    for prescaler in u64::from(first)..=u64::from(last) {
        for quanta in 8..=25 {
            if clock != bits_per_second * prescaler * quanta {
                continue;
            }
            for phase1 in 1..=8 {
                let phase2 = phase1.max(2).max(limits.segment2.first.into());
                if phase2 > limits.segment2.last.into() {
                    continue;
                }
                for propagation in 1..quanta {
                    for jump_width in 1..=phase1.min(4).min(limits.jump_width.into()) {
                        let setting = Setting { bits_per_second, propagation, phase1, phase2, jump_width };
                        found.extend((setting.quanta() == quanta).then_some(setting));
                    }
                }
            }
        }
    }
    found
}

#[derive(Clone, Copy, Debug)]
enum Clock {
    Hertz(u32),
    /// Of the bit rate.
    Multiple(u32),
}

fn networks() -> impl Strategy<Value = (u32, Network)> {
    let rates = prop_oneof![
        prop::sample::select(vec![10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000]),
        (10_u32..=1000).prop_map(|kbit| kbit * 1000),
    ];
    // Clocks that divide into any number of time quanta, common ones, any.
    let clocks = prop_oneof![
        3 => (8_u32..=25, 1_u32..=64).prop_map(|(quanta, prescaler)| Clock::Multiple(quanta * prescaler)),
        2 => prop::sample::select(vec![8, 10, 16, 24, 30, 32, 36, 42, 45, 48, 50])
            .prop_map(|mhz| Clock::Hertz(mhz * MHZ)),
        1 => any::<u32>().prop_map(Clock::Hertz),
    ];
    (rates, clocks, 0_u32..100, 0_u32..25, 0_u32..20_000, any::<bool>()).prop_map(
        |(bits_per_second, clock, length, delay, ppm, quartz)| {
            let clock = match clock {
                Clock::Hertz(hertz) => hertz,
                Clock::Multiple(clocks_per_bit) => clocks_per_bit * bits_per_second,
            };
            // Line and nodes take up to a bit and a quarter, there and back, so that many fit and many do not.
            let bit = 1_000_000_000 / bits_per_second;
            let network = Network {
                bit_rate: rate(bits_per_second),
                length: Metres((bit / 2 * length / 100 / 5) as u16),
                node_delay: Nanoseconds(bit / 8 * delay / 25),
                oscillator_tolerance: PartsPerMillion(if quartz { ppm / 100 } else { ppm }),
                jump_width: Network::JUMP_WIDTH,
            };
            (clock, network)
        },
    )
}

proptest! {
    #![proptest_config(cases(2_000))]

    /// Verifies: ECSS 5.4.3d
    /// Notices: ECSS 5.4.3c: of options with equal propagation the one with less tolerance is taken.
    #[test]
    fn brute_force_finds_nothing_better(
        (clock, network) in networks(),
        limits in prop::sample::select(vec![BXCAN, FDCAN, NARROW]),
    ) {
        let bits_per_second = u64::from(network.bit_rate.get());
        let needed = 2 * (u64::from(network.length.0) * 5 + u64::from(network.node_delay.0));
        let ppm = u64::from(network.oscillator_tolerance.0);
        // One constraint after the other.
        let exact = settings(&limits, u64::from(clock), bits_per_second);
        let sampled: Vec<_> = exact.iter().filter(|setting| setting.samples_in_range()).collect();
        let [shortest, longest] = [limits.segment1.first, limits.segment1.last].map(u64::from);
        let segment1 = |setting: &Setting| setting.propagation + setting.phase1;
        let fits = |setting: &Setting| (shortest..=longest).contains(&segment1(setting));
        let fitting: Vec<_> = sampled.iter().filter(|setting| fits(setting)).collect();
        let long: Vec<_> = fitting.iter().filter(|setting| setting.holds(needed)).collect();
        let good: Vec<_> = long.iter().filter(|setting| setting.tolerates(ppm)).collect();

        match BitTiming::new(&limits, Hertz(clock), &network) {
            Ok(timing) => {
                let chosen = good.iter().find(|setting| {
                    setting.propagation + setting.phase1 == u64::from(timing.segment1())
                        && setting.phase2 == u64::from(timing.segment2())
                        && setting.jump_width == u64::from(timing.jump_width())
                        && setting.jump_width == setting.phase1.min(4).min(limits.jump_width.into())
                });
                prop_assert!(chosen.is_some(), "{timing:?} is not among {good:?}");
                let quanta = u64::from(timing.quanta());
                prop_assert_eq!(u64::from(clock), bits_per_second * u64::from(timing.prescaler()) * quanta);
                let most = good.iter().find(|setting| {
                    setting.propagation * quanta > chosen.unwrap().propagation * setting.quanta()
                });
                prop_assert!(most.is_none(), "{most:?} has more propagation than {timing:?}");
                let tolerance = u64::from(timing.oscillator_tolerance().0);
                let better = good.iter().find(|setting| {
                    setting.propagation * quanta == chosen.unwrap().propagation * setting.quanta()
                        && setting.tolerates(tolerance + 1)
                });
                prop_assert!(better.is_none(), "{better:?} has more tolerance than {timing:?}");
            }
            Err(error) => {
                prop_assert!(good.is_empty(), "{error} in spite of {good:?}");
                match error {
                    BitTimingError::Prescaler { .. } => prop_assert!(exact.is_empty()),
                    BitTimingError::SamplePoint { .. } => prop_assert!(!exact.is_empty() && sampled.is_empty()),
                    BitTimingError::Segment1 { needed, .. } => {
                        prop_assert!(fitting.is_empty());
                        let outside = |length: u64| shortest.saturating_sub(length) + length.saturating_sub(longest);
                        let nearest = sampled.iter().map(|setting| outside(segment1(setting))).min();
                        prop_assert_eq!(nearest, Some(outside(needed.into())));
                    }
                    BitTimingError::Propagation { available, .. } => {
                        prop_assert!(long.is_empty());
                        let available = u64::from(available.0);
                        prop_assert!(fitting.iter().any(|setting| setting.holds(available)));
                        prop_assert!(!fitting.iter().any(|setting| setting.holds(available + 1)));
                    }
                    BitTimingError::Tolerance { available, .. } => {
                        let available = u64::from(available.0);
                        prop_assert!(long.iter().any(|setting| setting.tolerates(available)));
                        prop_assert!(!long.iter().any(|setting| setting.tolerates(available + 1)));
                    }
                }
            }
        }
    }
}

#[test]
fn every_error_says_what_is_needed_and_what_there_is() {
    for (error, text) in [
        (
            BitTimingError::Prescaler {
                clock: Hertz(42_000_000),
                bit_rate: BitRate::new(1_000_000).unwrap(),
                allowed: Range::new(1, 2),
            },
            "no prescaler of 1 to 2 makes 8 to 25 time quanta per bit, clock 42000000 Hz, bit rate 1000000 bit/s",
        ),
        (
            BitTimingError::SamplePoint { place: Permille(700), first: Permille(750), last: Permille(900) },
            "sample point at 700 per mille of the bit, allowed 750 to 900",
        ),
        (
            BitTimingError::Segment1 { needed: 17, allowed: Range::new(1, 16) },
            "segment 1 of 17 time quanta needed, allowed 1 to 16",
        ),
        (
            BitTimingError::Propagation { needed: Nanoseconds(900), available: Nanoseconds(714) },
            "propagation segment of 900 ns needed, 714 ns available",
        ),
    ] {
        assert_eq!(error.to_string(), format!("no bit timing: {text}"));
    }
}
