//! Third-party drivers: `twin/foreign`. They work on silicon, so they must work on the twin.

use std::sync::Arc;

use can_twin::board::{BoardConfig, Fittings};
use can_twin::crystal::Crystal;
use can_twin::image::Image;
use can_twin::model::{CanPins, Model, Pins};
use can_twin::pin::Pin;
use can_twin::rtt::Level;
use can_twin::spacecraft::{BoardId, Bus, Spacecraft, SpacecraftConfig, WireRecord, Wiring};
use can_twin::wire::fault::Fault;
use can_twin::wire::record::Observation;
use can_twin::wire::time::Time;
use ecss_can_cli::images::Package;
use flight::{PYBOARD_V11, bare, parsed};

/// Returns the image of `twin/foreign` that a feature selects.
fn image(feature: &str) -> Arc<Image> {
    let built = Package::of_workspace("foreign").build(feature).unwrap();
    parsed(&built[0])
}

/// The scenarios of the hardware test suite of `bxcan`, in the order in which the image runs them.
const SCENARIOS: [&str; 28] = [
    "loopback",
    "no_filter_no_frame",
    "priority",
    "fourth_frame_replaces_the_lowest",
    "equal_frames_keep_their_order",
    "abort",
    "transmit_interrupt",
    "pending_interrupt",
    "fifo_full",
    "fifo_overrun",
    "second_fifo",
    "sleep_interrupt",
    "mask32_standard",
    "mask32_extended",
    "mask16",
    "list32_standard",
    "list32_extended",
    "list16",
    "frame_kinds",
    "match_numbers",
    "match_priority",
    "both_ways",
    "split_of_the_filters",
    "filters_of_the_slave",
    "silent",
    "single_shot",
    "wake_up_by_traffic",
    "wake_up_by_software",
];

#[test]
fn bxcan_on_stm32f4xx_hal_passes_its_scenarios() {
    let wiring = Wiring { can1: Some(Bus::Nominal), can2: Some(Bus::Nominal) };
    let fittings = Fittings { wiring, ..Fittings::default() };
    let board = bare(PYBOARD_V11, image("pyboard-v11-bxcan"));
    // The program uses other pins for its controllers than a pyboard.
    let at = |rx, tx| CanPins { rx, tx };
    let can = [at(Pin::new('A', 11), Pin::new('A', 12)), at(Pin::new('B', 5), Pin::new('B', 6))];
    let model = Model { pins: Pins { can, ..board.model.pins }, ..board.model };
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    let id = spacecraft.add_board(BoardConfig { fittings, model, ..board });
    let refused = spacecraft.run_until(Time::from_ms(10_000)).unwrap_err();
    // Warnings are from the twin, not from the program.
    let said = spacecraft.take_logs().into_iter().filter(|log| log.level != Some(Level::Warn));
    let lines: Vec<_> = said.map(|log| log.text).collect();
    let expected = SCENARIOS.map(|name| format!("scenario {name} passed"));
    assert_eq!(lines.split_last(), Some((&"done".to_owned(), &expected[..])), "{lines:#?}");
    assert_eq!(spacecraft.board(id).counters().panics, 0);
    // An access that the twin does not model stops the board, and the error names it.
    assert_eq!((refused.address, refused.register.as_deref()), (0x4000_7400, Some("DAC.CR")), "{refused}");
    let function = refused.function.as_deref().unwrap_or_else(|| panic!("{refused}"));
    assert!(function.ends_with("::beyond"), "{refused}");
    assert!(refused.to_string().contains(&format!("in {function} ")), "{refused}");
}

/// Returns two boards with embassy-stm32's CAN driver, selected by `feature`, at a distance of 10 m: board 0 asks,
/// board 1 answers.
fn two_with_embassy(feature: &str) -> Spacecraft {
    let image = image(feature);
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    spacecraft.add_board(BoardConfig { crystal: Crystal::ppm(40.0), ..bare(PYBOARD_V11, image.clone()) });
    spacecraft.add_board(BoardConfig {
        crystal: Crystal::ppm(-40.0),
        position_m: 10.0,
        straps: vec![(Pin::new('A', 2), false)],
        ..bare(PYBOARD_V11, image)
    });
    spacecraft
}

fn fly_to(spacecraft: &mut Spacecraft, ms: u64) {
    spacecraft.run_until(Time::from_ms(ms)).unwrap();
}

/// Returns the numbers in the frames that a board completed.
fn numbers(records: &[WireRecord], board: usize) -> Vec<u32> {
    let of_board = |record: &WireRecord| match &record.record {
        Observation::Completed { trace, .. } if trace.transmitter == board => {
            Some(u32::from_le_bytes(trace.frame.payload().try_into().unwrap()))
        }
        _ => None,
    };
    records.iter().filter_map(of_board).collect()
}

#[test]
fn embassys_driver_talks_both_ways() {
    let mut spacecraft = two_with_embassy("pyboard-v11");
    fly_to(&mut spacecraft, 100);
    let records = spacecraft.take_frames();
    let (asked, answered) = (numbers(&records, 0), numbers(&records, 1));
    assert_eq!(asked, (0..asked.len() as u32).collect::<Vec<_>>());
    // A question each millisecond from about 3 ms on.
    assert!((90..=100).contains(&asked.len()), "{}", asked.len());
    assert_eq!(answered, asked);
    let log: Vec<_> = spacecraft.take_logs().into_iter().map(|log| (log.board.0, log.text)).collect();
    let started = |board| (board, "on the bus".to_owned());
    assert!(log.len() == 2 && [0, 1].iter().all(|&board| log.contains(&started(board))), "{log:?}");
}

/// Given a bus that is stuck at one level, when it is repaired, then boards in bus-off recover by themselves and
/// continue with the pending frame.
#[test]
fn embassys_driver_recovers_from_bus_off() {
    let mut spacecraft = two_with_embassy("pyboard-v11");
    fly_to(&mut spacecraft, 20);
    spacecraft.take_frames();
    // Recessive: the sender detects a bit error at its first bit in each attempt.
    let short = Fault::Short { position_m: 5.0, level: true };
    spacecraft.wire_mut(Bus::Nominal).schedule(Time::from_ms(20), short).unwrap();
    fly_to(&mut spacecraft, 40);
    assert!(spacecraft.wire(Bus::Nominal).error_counters(0).bus_off(), "the sender is bus-off");
    let shorted = spacecraft.take_frames();
    assert_eq!((numbers(&shorted, 0), numbers(&shorted, 1)), (vec![], vec![]));
    spacecraft.wire_mut(Bus::Nominal).schedule(Time::from_ms(40), Fault::ClearShorts).unwrap();
    fly_to(&mut spacecraft, 100);
    let counters = spacecraft.wire(Bus::Nominal).error_counters(0);
    assert_eq!((counters.transmit, counters.receive), (0, 0));
    let records = spacecraft.take_frames();
    let (asked, answered) = (numbers(&records, 0), numbers(&records, 1));
    // One question for each millisecond since 20 ms: the ticker catches up delayed ones.
    assert!((75..=81).contains(&asked.len()), "{}", asked.len());
    assert!(asked.is_sorted_by(|one, next| one + 1 == *next), "{asked:?}");
    assert_eq!(answered, asked);
    let logs = spacecraft.take_logs();
    let said = |text: &str| logs.iter().filter(|log| log.board == BoardId(0) && log.text == text).count();
    assert_eq!((said("the bus fails"), said("the bus works again")), (1, 1), "{logs:#?}");
}

/// Given the clock of embassy-time on TIM3, TIM4 or TIM12, which have 16 bits, then a question is asked each
/// millisecond, even after three overflows of the timer.
#[test]
fn embassys_time_driver_runs_on_timers_of_16_bits() {
    for timer in ["tim3", "tim4", "tim12"] {
        let mut spacecraft = two_with_embassy(&format!("pyboard-v11-{timer}"));
        fly_to(&mut spacecraft, 250);
        let records = spacecraft.take_frames();
        let (asked, answered) = (numbers(&records, 0), numbers(&records, 1));
        assert_eq!(asked, (0..asked.len() as u32).collect::<Vec<_>>(), "{timer}");
        // From about 3 ms on.
        assert!((240..=250).contains(&asked.len()), "{timer}: {}", asked.len());
        assert!(asked.len() - answered.len() <= 1, "{timer}: {answered:?}");
    }
}
