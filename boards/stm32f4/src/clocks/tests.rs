use super::{ClockError, Clocks, Oscillator, OscillatorKind, PCLK1, TIMERS};

const FAST: u32 = 168_000_000;
const SLOW: u32 = 84_000_000;

/// Settings in a constant, as boards declare them.
const PYBOARD: Clocks = match Clocks::new(Oscillator::crystal(12_000_000), FAST) {
    Ok(clocks) => clocks,
    Err(error) => panic!("{}", error.message().as_str()),
};

/// Returns each whole MHz, the ends of all ranges and 1 Hz beyond them, and frequencies of common crystals.
fn frequencies() -> impl Iterator<Item = u32> {
    let odd = [
        0,
        999_999,
        1_000_001,
        1_843_200,
        2_097_152,
        2_457_600,
        3_276_800,
        3_579_545,
        3_686_400,
        3_999_999,
        4_194_304,
        4_915_200,
        5_500_000,
        6_144_000,
        7_372_800,
        8_192_000,
        9_216_000,
        9_830_400,
        10_500_000,
        11_059_200,
        12_288_000,
        13_560_000,
        14_318_180,
        14_745_600,
        16_384_000,
        16_800_000,
        18_432_000,
        19_200_000,
        19_660_800,
        20_480_000,
        22_118_400,
        24_576_000,
        25_999_999,
        26_000_001,
        27_120_000,
        32_768_000,
        33_333_333,
        33_600_000,
        38_400_000,
        49_152_000,
        49_999_999,
        50_000_001,
        51_000_000,
        u32::MAX,
    ];
    (1..=50).map(|mhz| mhz * 1_000_000).chain(odd)
}

/// Returns each (PLLM, PLLN, PLLP) within the limits of RM0090 7.3.2 that gives HCLK exactly.
fn solutions(hz: u32, hclk: u32) -> Vec<(u8, u16, u8)> {
    let (hz, hclk) = (u128::from(hz), u128::from(hclk));
    let mut found = Vec::new();
    for m in 2..=63_u8 {
        for n in 50..=432_u16 {
            for p in [2_u8, 4, 6, 8] {
                // Frequencies times PLLM, which are whole numbers.
                let scale = u128::from(m);
                let (input, output) = (hz, hz * u128::from(n));
                let input_is_allowed = (1_000_000 * scale..=2_000_000 * scale).contains(&input);
                let output_is_allowed = (100_000_000 * scale..=432_000_000 * scale).contains(&output);
                if input_is_allowed && output_is_allowed && output == hclk * u128::from(p) * scale {
                    found.push((m, n, p));
                }
            }
        }
    }
    found
}

#[test]
fn common_oscillators_have_settings_calculated_by_hand() {
    // Oscillator, HCLK: PLLM, PLLN, PLLP.
    let expected = [
        (Oscillator::crystal(4_000_000), FAST, (2, 168, 2)),
        (Oscillator::crystal(8_000_000), FAST, (4, 168, 2)),
        (Oscillator::external(8_000_000), FAST, (4, 168, 2)),
        (Oscillator::crystal(12_000_000), FAST, (6, 168, 2)),
        (Oscillator::crystal(16_000_000), FAST, (8, 168, 2)),
        (Oscillator::crystal(19_200_000), FAST, (10, 175, 2)),
        (Oscillator::crystal(25_000_000), FAST, (25, 336, 2)),
        (Oscillator::crystal(26_000_000), FAST, (13, 168, 2)),
        (Oscillator::external(2_000_000), FAST, (2, 336, 2)),
        (Oscillator::external(50_000_000), FAST, (25, 168, 2)),
        (Oscillator::crystal(8_000_000), SLOW, (4, 168, 4)),
        (Oscillator::crystal(25_000_000), SLOW, (25, 336, 4)),
    ];
    for (oscillator, hclk, settings) in expected {
        let clocks = Clocks::new(oscillator, hclk).unwrap();
        assert_eq!((clocks.prediv, clocks.multiplier, clocks.divider), settings, "{oscillator:?}, {hclk}");
    }
    assert_eq!((PYBOARD.prediv, PYBOARD.multiplier, PYBOARD.divider), (6, 168, 2));
}

/// Given both kinds of oscillator at each frequency, when both HCLK are requested, then settings are found exactly where the
/// oscillator is in its range and a search over all registers finds some. They are those with the highest VCO input.
#[test]
fn settings_are_found_exactly_where_they_exist() {
    let (mut accepted, mut refused) = (0, 0);
    for hz in frequencies() {
        for hclk in [FAST, SLOW] {
            let solutions = solutions(hz, hclk);
            for (oscillator, allowed) in [
                (Oscillator::crystal(hz), 4_000_000..=26_000_000),
                (Oscillator::external(hz), 1_000_000..=50_000_000),
            ] {
                let outcome = Clocks::new(oscillator, hclk);
                if !allowed.contains(&hz) {
                    let kind = oscillator.kind();
                    assert_eq!(outcome, Err(ClockError::OscillatorRange { hz, kind }));
                    continue;
                }
                match outcome {
                    Ok(clocks) => {
                        let settings = (clocks.prediv, clocks.multiplier, clocks.divider);
                        assert!(solutions.contains(&settings), "{hz} Hz: {settings:?}");
                        // The least PLLM that gives a whole number of Hz; of these the greatest PLLP.
                        let whole = solutions.iter().filter(|(m, ..)| hz % u32::from(*m) == 0);
                        let best = whole.min_by_key(|(m, _, p)| (*m, 8 - *p));
                        assert_eq!(best, Some(&settings), "{hz} Hz");
                        assert_eq!(clocks.hclk, hclk);
                        accepted += 1;
                    }
                    Err(error) => {
                        assert_eq!(error, ClockError::NoPll { hz, hclk });
                        assert_eq!(solutions, [], "{hz} Hz");
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(accepted > 100 && refused > 50, "{accepted} accepted, {refused} refused");
}

#[test]
fn each_whole_mhz_but_1_gives_settings() {
    for mhz in 4..=26 {
        assert!(Clocks::new(Oscillator::crystal(mhz * 1_000_000), FAST).is_ok(), "{mhz} MHz");
    }
    for mhz in 2..=50 {
        assert!(Clocks::new(Oscillator::external(mhz * 1_000_000), FAST).is_ok(), "{mhz} MHz");
    }
    // PLLM is at least 2: the VCO would get 0.5 MHz.
    let refused = Err(ClockError::NoPll { hz: 1_000_000, hclk: FAST });
    assert_eq!(Clocks::new(Oscillator::external(1_000_000), FAST), refused);
}

/// Given 21 MHz, which PLLM = 11 divides to 1909090.9 Hz, when settings are found, then PLLM is 12: a HAL that computes in whole Hz
/// would take HCLK for 167999920 Hz, and set timers of 1 MHz to 1.012 MHz.
#[test]
fn vco_input_is_a_whole_number_of_hz() {
    let clocks = Clocks::new(Oscillator::crystal(21_000_000), FAST).unwrap();
    assert_eq!((clocks.prediv, clocks.multiplier, clocks.divider), (12, 192, 2));
}

#[test]
fn crystals_for_serial_ports_and_audio_are_refused() {
    for hz in [8_192_000, 11_059_200, 14_745_600, 24_576_000] {
        let refused = Err(ClockError::NoPll { hz, hclk: FAST });
        assert_eq!(Clocks::new(Oscillator::crystal(hz), FAST), refused);
    }
}

#[test]
fn apb1_has_42_mhz_its_timers_84_and_apb2_84() {
    for hclk in [FAST, SLOW] {
        let clocks = Clocks::new(Oscillator::crystal(8_000_000), hclk).unwrap();
        assert_eq!(hclk / u32::from(clocks.apb1), 42_000_000);
        // A timer runs at twice the clock of its bus if that clock is divided (RM0090 7.2).
        assert!(clocks.apb1 > 1);
        assert_eq!(hclk / u32::from(clocks.apb1) * 2, 84_000_000);
        assert_eq!(hclk / u32::from(clocks.apb2), 84_000_000);
    }
    assert_eq!((PCLK1, TIMERS), (42_000_000, 84_000_000));
}

#[test]
fn each_other_hclk_is_refused() {
    let whole = (0..=200).map(|mhz| mhz * 1_000_000).filter(|hclk| ![FAST, SLOW].contains(hclk));
    for hclk in whole.chain([FAST - 1, FAST + 1, SLOW - 1, SLOW + 1, u32::MAX]) {
        assert_eq!(Clocks::new(Oscillator::crystal(8_000_000), hclk), Err(ClockError::Hclk { hclk }));
    }
}

#[test]
fn message_names_the_wrong_value_and_what_is_allowed() {
    let range = |hz, kind| ClockError::OscillatorRange { hz, kind };
    let expected = [
        (range(3_999_999, OscillatorKind::Crystal), "no clocks: crystal of 3999999 Hz, allowed 4 to 26 MHz"),
        (
            range(51_000_000, OscillatorKind::External),
            "no clocks: external clock of 51000000 Hz, allowed 1 to 50 MHz",
        ),
        (
            ClockError::Hclk { hclk: 180_000_000 },
            "no clocks: HCLK of 180000000 Hz, allowed 168000000 or 84000000 Hz: bit timing and time stamps need APB1 at 42 \
             MHz and its timers at 84 MHz",
        ),
        (
            ClockError::NoPll { hz: 8_192_000, hclk: FAST },
            "no clocks: oscillator of 8192000 Hz does not give HCLK of 168000000 Hz exactly, take a whole number of MHz; \
             PLLM 2 to 63, PLLN 50 to 432, VCO input 1 to 2 MHz, VCO output 100 to 432 MHz",
        ),
    ];
    for (error, message) in expected {
        assert_eq!(error.message().as_str(), message);
        assert_eq!(error.to_string(), message);
    }
}

/// Given the greatest numbers, when they are put into messages, then no message is cut off.
#[test]
fn messages_with_the_greatest_numbers_are_complete() {
    let most = u32::MAX;
    for (error, end) in [
        (ClockError::OscillatorRange { hz: most, kind: OscillatorKind::External }, "50 MHz"),
        (ClockError::Hclk { hclk: most }, "84 MHz"),
        (ClockError::NoPll { hz: most, hclk: most }, "432 MHz"),
    ] {
        assert!(error.message().as_str().ends_with(end), "{error}");
    }
}
